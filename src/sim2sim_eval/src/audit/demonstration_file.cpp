// SPDX-License-Identifier: BSD-3-Clause
#include <pusht_msgs/DemonstrationStep.h>
#include <rosbag/view.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "pusht_policy/demonstrations.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/split.hpp"
#include "sim2sim_eval/policy_audit_run.hpp"
#include "sim2sim_serving/bag_file.hpp"

namespace sim2sim {
namespace {

using pusht::Action;
using pusht::Observation;

constexpr std::size_t kObservationNumbers = std::tuple_size<Observation>::value;
constexpr std::size_t kNumbers = kObservationNumbers + std::tuple_size<Action>::value;
/// Names of a row's numbers, in their order.
constexpr std::array<std::array<const char*, 2>, kNumbers> kNames = {{{"o0", "pusher_x"},
                                                                      {"o1", "pusher_y"},
                                                                      {"o2", "tee_x"},
                                                                      {"o3", "tee_y"},
                                                                      {"o4", "tee_sin"},
                                                                      {"o5", "tee_cos"},
                                                                      {"o6", "target_x"},
                                                                      {"o7", "target_y"},
                                                                      {"o8", "target_sin"},
                                                                      {"o9", "target_cos"},
                                                                      {"a0", "action_x"},
                                                                      {"a1", "action_y"}}};
constexpr const char* kEpisodeColumn = "episode";

/// Columns of a CSV, as its first line names them.
class CsvColumns {
 public:
  explicit CsvColumns(const std::string& line) : names_(pusht::cellsOf(line)) {
    for (std::size_t i = 0; i < kNumbers; ++i) {
      const auto& [short_name, long_name] = kNames[i];
      const std::optional<std::size_t> column = find(short_name);
      const std::optional<std::size_t> other = find(long_name);
      if (column.has_value() == other.has_value()) {
        throw pusht::InvalidInput(std::string("column '") + short_name + "' or '" + long_name +
                                  "': " + (column ? "must appear only once" : "is missing"));
      }
      numbers_[i] = column ? *column : *other;
    }
    episode_ = find(kEpisodeColumn);
  }

  /// Cells of a row. Throws InvalidInput unless there is one for each column.
  std::vector<std::string> cellsIn(const std::string& line) const {
    std::vector<std::string> cells = pusht::cellsOf(line);
    if (cells.size() != names_.size()) {
      throw pusht::InvalidInput(std::to_string(cells.size()) + " values: must be " + std::to_string(names_.size()) +
                                ", one for each column");
    }
    return cells;
  }

  std::string episodeIn(const std::vector<std::string>& cells) const { return episode_ ? cells[*episode_] : ""; }

  void addTo(Demonstration& demonstration, const std::vector<std::string>& cells) const {
    Observation observation{};
    Action action{};
    for (std::size_t i = 0; i < kNumbers; ++i) {
      const std::string& cell = cells[numbers_[i]];
      const std::optional<float> number = pusht::decimal<float>(cell);
      if (!number) {
        throw pusht::InvalidInput("column '" + names_[numbers_[i]] + "' '" + cell + "': must be a decimal number");
      }
      (i < kObservationNumbers ? observation[i] : action[i - kObservationNumbers]) = *number;
    }
    demonstration.observations.push_back(observation);
    demonstration.actions.push_back(action);
  }

 private:
  std::optional<std::size_t> find(const std::string& name) const {
    const auto column = std::find(names_.begin(), names_.end(), name);
    if (column == names_.end()) {
      return std::nullopt;
    }
    if (std::count(column, names_.end(), name) > 1) {
      throw pusht::InvalidInput("column '" + name + "': must appear only once");
    }
    return static_cast<std::size_t>(column - names_.begin());
  }

  std::vector<std::string> names_;
  std::array<std::size_t, kNumbers> numbers_{};
  std::optional<std::size_t> episode_;
};

/// Rows of a CSV as they come.
class CsvReader {
 public:
  void take(const std::string& line) {
    if (!columns_) {
      columns_.emplace(line);
      return;
    }
    const std::vector<std::string> cells = columns_->cellsIn(line);
    const std::string episode = columns_->episodeIn(cells);
    if (demonstrations_.empty() || episode != episode_) {
      if (!seen_.insert(episode).second) {
        throw pusht::InvalidInput("episode '" + episode + "': its rows must follow each other");
      }
      episode_ = episode;
      demonstrations_.emplace_back();
    }
    columns_->addTo(demonstrations_.back(), cells);
  }

  std::vector<Demonstration> demonstrations() const {
    if (demonstrations_.empty()) {
      throw pusht::InvalidInput("has 0 rows: must have a line of names and a row for each control step");
    }
    return demonstrations_;
  }

 private:
  std::optional<CsvColumns> columns_;
  std::vector<Demonstration> demonstrations_;
  std::set<std::string> seen_;
  std::string episode_;
};

bool areFinite(const pusht_msgs::DemonstrationStep& step) {
  const auto is_finite = [](float number) { return std::isfinite(number); };
  return std::all_of(step.observation.begin(), step.observation.end(), is_finite) &&
         std::all_of(step.action.begin(), step.action.end(), is_finite);
}

void add(std::map<std::uint64_t, Demonstration>& by_seed, const pusht_msgs::DemonstrationStep& step) {
  const std::string where = "seed " + std::to_string(step.seed) + ", step " + std::to_string(step.step) + ": ";
  Demonstration& demonstration = by_seed[step.seed];
  if (step.step != demonstration.actions.size()) {
    throw pusht::InvalidInput(where + "must be step " + std::to_string(demonstration.actions.size()));
  }
  if (!areFinite(step)) {
    throw pusht::InvalidInput(where + "all numbers must be finite");
  }
  demonstration.observations.emplace_back();
  std::copy(step.observation.begin(), step.observation.end(), demonstration.observations.back().begin());
  demonstration.actions.push_back({step.action[0], step.action[1]});
}

std::vector<Demonstration> demonstrationsIn(const rosbag::Bag& bag) {
  std::map<std::uint64_t, Demonstration> by_seed;
  rosbag::View view(bag, rosbag::TopicQuery(pusht::kDemonstrationStepTopic));
  for (const rosbag::MessageInstance& instance : view) {
    add(by_seed, pusht::messageIn<pusht_msgs::DemonstrationStep>(instance));
  }
  if (by_seed.empty()) {
    throw pusht::InvalidInput(std::string("has no messages on ") + pusht::kDemonstrationStepTopic +
                              ": must be a bag of `demonstrate`");
  }
  std::vector<Demonstration> demonstrations;
  demonstrations.reserve(by_seed.size());
  for (auto& [seed, demonstration] : by_seed) {
    demonstrations.push_back(std::move(demonstration));
  }
  return demonstrations;
}

/// Demonstrations in the text of a CSV. Throws InvalidInput with line, column, value and rule.
std::vector<Demonstration> demonstrationsFrom(const std::string& csv) {
  std::istringstream text(csv);
  CsvReader reader;
  int number = 0;
  try {
    for (std::string line; std::getline(text, line);) {
      ++number;
      reader.take(line);
    }
  } catch (pusht::Error& error) {
    error.addContext("line " + std::to_string(number));
    throw;
  }
  return reader.demonstrations();
}

}  // namespace

std::vector<Demonstration> readDemonstrations(const std::filesystem::path& path) {
  std::vector<Demonstration> demonstrations;
  if (path.extension() != ".csv") {
    pusht::readBag(path, [&](const rosbag::Bag& bag) { demonstrations = demonstrationsIn(bag); });
    return demonstrations;
  }
  const std::string csv = pusht::readFile(path, "demonstrations");
  try {
    return demonstrationsFrom(csv);
  } catch (pusht::Error& error) {
    error.addContext("demonstrations " + path.string());
    throw;
  }
}

}  // namespace sim2sim
