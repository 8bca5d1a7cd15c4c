// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/matrix.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "group_tables.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/split.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/run_results.hpp"
#include "sim2sim_statistics/crossed.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// "MuJoCo, timestep 0.005" of "mujoco:timestep=0.005".
std::string titleOf(const std::string& name, const std::string& title) {
  std::string text = title;
  const std::vector<std::string> parts = pusht::split(name, ':');
  for (std::size_t i = 1; i < parts.size(); ++i) {
    std::string setting = parts[i];
    std::replace(setting.begin(), setting.end(), '=', ' ');
    text.append(", ").append(setting);
  }
  return text;
}

/// Throws InvalidInput unless the sweep is a whole one that lists policies, each in one loop.
void requireMatrix(const SweepResults& sweep) {
  sweep.requireWhole();
  if (!sweep.description.contains("policies")) {
    throw pusht::InvalidInput("results " + (sweep.folder / kSweepFile).string() +
                              ": lists no policies; a plan with the key policies is needed");
  }
  std::set<std::string> names;
  for (const json& policy : sweep.description.at("policies")) {
    if (const std::string name = policy.at("policy"); !names.insert(name).second) {
      throw pusht::InvalidInput("results " + (sweep.folder / kSweepFile).string() + ": has policy " + name +
                                " in several loops; a sweep for each loop is needed");
    }
  }
}

/// Names of the groups that a sweep lists, each once.
std::string groupsIn(const json& description) {
  std::vector<std::string> names;
  for (const json& policy : description.at("policies")) {
    const std::string name = policy.at("group");
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) {
      names.push_back(name);
    }
  }
  return names.empty() ? "which has none" : pusht::joined(names);
}

std::vector<bool> successesOf(const std::vector<EpisodeResult>& episodes, std::size_t rollout) {
  std::vector<bool> successes;
  std::transform(episodes.begin(), episodes.end(), std::back_inserter(successes),
                 [rollout](const EpisodeResult& episode) { return episode.rollouts[rollout].success; });
  return successes;
}

SuccessRate rateOf(const std::vector<bool>& successes) {
  const auto count = static_cast<int>(std::count(successes.begin(), successes.end(), true));
  const auto trials = static_cast<int>(successes.size());
  return {count, static_cast<double>(count) / trials, wilsonInterval(count, trials)};
}

MatrixCell cellOf(const fs::path& row, std::vector<bool> successes) {
  MatrixCell cell{row.string(), std::move(successes)};
  cell.success = rateOf(cell.successes);
  return cell;
}

/// The engine's cell of a row.
MatrixCell engineCell(const fs::path& row, const RunResults& results) {
  MatrixCell cell = cellOf(row, successesOf(results.episodes, kEngineClosed));
  const Summary summary = summarize(results.protocol, results.episodes);
  cell.transfer = summary.outcomes.transfer;
  cell.transfer_interval = summary.outcomes.transfer_interval;
  for (std::size_t i = 0; i < kMatrixDivergences.size(); ++i) {
    const std::size_t quantity = quantityIndex(kMatrixDivergences[i]);
    std::transform(results.episodes.begin(), results.episodes.end(), std::back_inserter(cell.divergences[i]),
                   [&](const EpisodeResult& episode) { return episode.rollouts[kEngineReplay].quantities[quantity]; });
    cell.mean_divergences[i] = summary.means[kEngineReplay][quantity];
  }
  return cell;
}

/// Matrix while its rows are read.
class Reader {
 public:
  /// Takes the policies of `groups`, or all.
  Reader(const json& description, const std::vector<std::string>& groups) {
    for (const json& policy : description.at("policies")) {
      const json& reference = policy.at("inputs").at("reference");
      const std::string group = policy.at("group");
      const bool is_wanted = groups.empty() || std::find(groups.begin(), groups.end(), group) != groups.end();
      places_.push_back(is_wanted ? std::optional<std::size_t>(matrix_.policies.size()) : std::nullopt);
      if (is_wanted) {
        matrix_.policies.push_back(
            {policy.at("policy"), group, columnOf(policy.at("reference"), reference.at("title"))});
      }
    }
    matrix_.cells.resize(matrix_.policies.size());
    for (const std::string& group : groups) {
      if (std::none_of(matrix_.policies.begin(), matrix_.policies.end(),
                       [&](const MatrixPolicy& policy) { return policy.group == group; })) {
        throw pusht::InvalidInput("group " + group + ": must be one of the sweep's, " + groupsIn(description));
      }
    }
  }

  /// Whether a policy, by its number in sweep.json, is wanted.
  bool isWanted(std::size_t policy) const { return policy >= places_.size() || places_[policy]; }

  /// Adds a row of a policy, by its number in sweep.json; `name` is the engine's.
  void add(std::size_t number, const std::string& name, const fs::path& row, const RunResults& results) {
    if (number >= places_.size()) {
      throw pusht::InvalidInput("results " + results.folder.string() + ": is of policy " + std::to_string(number) +
                                "; must be one that sweep.json lists");
    }
    const std::size_t engine = columnOf(name, results.engine().at("title"));
    const std::size_t policy = places_[number].value();
    MatrixPolicy& its_policy = matrix_.policies.at(policy);
    std::optional<MatrixCell>& reference = cellAt(policy, its_policy.reference);
    const std::vector<bool> in_reference = successesOf(results.episodes, kReferenceClosed);
    if (!reference) {
      reference = cellOf(row, in_reference);
    } else if (reference->successes != in_reference) {
      throw pusht::InvalidInput("results " + results.folder.string() + ": policy " + its_policy.name +
                                " did not do the same in its reference as in " + reference->sweep_row);
    }
    cellAt(policy, engine) = engineCell(row, results);
    matrix_.episodes = static_cast<int>(in_reference.size());
    matrix_.first_episode = results.episodes.front().index;
  }

  Matrix finished() {
    for (std::vector<std::optional<MatrixCell>>& cells : matrix_.cells) {
      cells.resize(matrix_.simulators.size());
    }
    return std::move(matrix_);
  }

 private:
  std::size_t columnOf(const std::string& name, const std::string& title) {
    std::vector<MatrixSimulator>& known = matrix_.simulators;
    const auto place =
        std::find_if(known.begin(), known.end(), [&](const MatrixSimulator& other) { return other.name == name; });
    const auto column = static_cast<std::size_t>(place - known.begin());
    if (place == known.end()) {
      known.push_back({name, titleOf(name, title)});
    }
    return column;
  }

  std::optional<MatrixCell>& cellAt(std::size_t policy, std::size_t simulator) {
    std::vector<std::optional<MatrixCell>>& cells = matrix_.cells[policy];
    cells.resize(std::max(cells.size(), simulator + 1));
    return cells[simulator];
  }

  Matrix matrix_{};
  std::vector<std::optional<std::size_t>> places_;  ///< in the matrix, by number in sweep.json; none: not wanted
};

/// Values of a figure, by policy and start, in one simulator; none if a policy does not have it.
using FigureOf = std::function<std::optional<std::vector<double>>(std::size_t policy, std::size_t simulator)>;

/// Spread of a figure over all policies that have a group, in the simulators where all of them have it.
std::optional<MatrixSpread> spreadOf(const Matrix& matrix, const std::string& figure, const FigureOf& values) {
  std::vector<std::size_t> groups;
  std::vector<std::size_t> simulators;
  Rows all;  // simulator by simulator
  for (std::size_t simulator = 0; simulator < matrix.simulators.size(); ++simulator) {
    Rows rows;
    std::size_t member_count = 0;
    for (const MatrixGroup& group : matrix.groups) {
      for (const std::size_t policy : group.policies) {
        ++member_count;
        if (auto row = values(policy, simulator)) {
          rows.push_back(*std::move(row));
        }
      }
    }
    if (rows.size() == member_count) {
      simulators.push_back(simulator);
      std::move(rows.begin(), rows.end(), std::back_inserter(all));
    }
  }
  for (std::size_t group = 0; group < matrix.groups.size(); ++group) {
    groups.insert(groups.end(), matrix.groups[group].policies.size(), group);
  }
  const bool has_policies = groups.size() > matrix.groups.size();
  if (matrix.groups.size() < 2 || simulators.size() < 2 || !has_policies) {
    return std::nullopt;
  }
  const Rows dense = withoutGaps(all);
  if (dense.front().size() < 2) {
    return std::nullopt;
  }
  std::vector<CrossedTable> tables;
  for (auto row = dense.begin(); row != dense.end(); row += static_cast<std::ptrdiff_t>(groups.size())) {
    tables.emplace_back(Rows(row, row + static_cast<std::ptrdiff_t>(groups.size())));
  }
  return MatrixSpread{figure, simulators, sim2sim::spreadOf(tables, groups)};
}

/// Success by start such that its mean is the transfer, and its spread over starts that of the transfer: the ratio's
/// first-order expansion (the delta method).
std::vector<double> transferByStart(const MatrixCell& cell, const MatrixCell& reference) {
  std::vector<double> values(cell.successes.size());
  for (std::size_t start = 0; start < values.size(); ++start) {
    const double residual = cell.successes[start] - *cell.transfer * reference.successes[start];
    values[start] = *cell.transfer + residual / reference.success.rate;
  }
  return values;
}

std::vector<MatrixSpread> spreadsOf(const Matrix& matrix) {
  std::vector<std::optional<MatrixSpread>> found;
  found.push_back(spreadOf(matrix, "success", [&](std::size_t policy, std::size_t simulator) {
    const std::optional<MatrixCell>& cell = matrix.cells[policy][simulator];
    return cell ? std::optional(numbersOf(cell->successes)) : std::nullopt;
  }));
  found.push_back(spreadOf(matrix, "transfer", [&](std::size_t policy, std::size_t simulator) {
    const std::vector<std::optional<MatrixCell>>& cells = matrix.cells[policy];
    const bool has_transfer =
        cells[simulator] && cells[simulator]->transfer && std::isfinite(*cells[simulator]->transfer);
    return has_transfer ? std::optional(transferByStart(*cells[simulator], *cells[matrix.policies[policy].reference]))
                        : std::nullopt;
  }));
  for (std::size_t i = 0; i < kMatrixDivergences.size(); ++i) {
    found.push_back(spreadOf(matrix, kMatrixDivergences[i], [&](std::size_t policy, std::size_t simulator) {
      const std::optional<MatrixCell>& cell = matrix.cells[policy][simulator];
      return cell && simulator != matrix.policies[policy].reference ? std::optional(cell->divergences[i])
                                                                    : std::nullopt;
    }));
  }
  std::vector<MatrixSpread> spreads;
  for (std::optional<MatrixSpread>& spread : found) {
    if (spread) {
      spreads.push_back(*std::move(spread));
    }
  }
  return spreads;
}

std::vector<MatrixRanking> rankingsOf(const Matrix& matrix) {
  std::vector<MatrixRanking> rankings;
  for (std::size_t reference = 0; reference < matrix.simulators.size(); ++reference) {
    for (std::size_t test = 0; test < matrix.simulators.size(); ++test) {
      Rows in_reference;
      Rows in_test;
      for (const std::vector<std::optional<MatrixCell>>& cells : matrix.cells) {
        if (reference != test && cells[reference] && cells[test]) {
          in_reference.push_back(numbersOf(cells[reference]->successes));
          in_test.push_back(numbersOf(cells[test]->successes));
        }
      }
      if (in_reference.size() > 1 && matrix.episodes > 1) {
        rankings.push_back(
            {reference, test, in_reference.size(), compareRankings(CrossedTable(in_reference), CrossedTable(in_test))});
      }
    }
  }
  return rankings;
}

}  // namespace

Matrix readMatrix(const fs::path& folder, const std::vector<std::string>& groups, const std::function<void()>& go_on) {
  const SweepResults sweep = readSweep(folder);
  requireMatrix(sweep);
  const json& description = sweep.description;
  const std::vector<fs::path> rows = sweep.rowFolders();
  try {
    Reader reader(description, groups);
    if (const int repeats = description.value("repeats", 1); repeats > 1) {
      throw pusht::InvalidInput("results " + (folder / kSweepFile).string() + ": has " + std::to_string(repeats) +
                                " repeats of each start; a matrix takes sweeps with one, because it pairs policies "
                                "episode by episode");
    }
    for (std::size_t row = 0; row < rows.size(); ++row) {
      go_on();
      const json& described = description.at("rows").at(row);
      if (!reader.isWanted(described.at("policy"))) {
        continue;
      }
      reader.add(described.at("policy"), described.at("name"), rows[row].lexically_relative(folder),
                 readResults(rows[row]));
    }
    Matrix matrix = reader.finished();
    matrix.groups = groupsOf(matrix);
    matrix.rankings = rankingsOf(matrix);
    matrix.spreads = spreadsOf(matrix);
    return matrix;
  } catch (const json::exception& error) {
    throw pusht::InvalidInput("results " + (folder / kSweepFile).string() +
                              ": must be as it was written: " + error.what());
  }
}

}  // namespace sim2sim
