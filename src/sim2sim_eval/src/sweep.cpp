// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/sweep.hpp"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_eval/command_line.hpp"
#include "sim2sim_eval/sweep_folder.hpp"
#include "sim2sim_eval/sweep_plan.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The run that a row is.
RunConfiguration rowConfiguration(const Protocol& protocol, const std::string& policy,
                                  const pusht::TwoMassParameters& knobs) {
  RunConfiguration configuration;
  configuration.protocol = protocol;
  configuration.policy = policy;
  describeSimulators(configuration, knobs);
  return configuration;
}

/// What decides a sweep, as in sweep.json; the same for all its shards.
json descriptionOf(const SweepPlan& plan, const Setup& setup) {
  const RunConfiguration first = rowConfiguration(plan.protocol, setup.policyName(), plan.rows.front());
  json description = describe(first);
  description.erase("knobs");
  description.erase("config_hash");
  description.erase("smoke");
  description["inputs"] = setup.identity();
  for (const pusht::TwoMassParameters& knobs : plan.rows) {
    description["rows"].push_back(json(rowConfiguration(plan.protocol, setup.policyName(), knobs).knobs));
  }
  return description;
}

/// The configuration of row `index` of a sweep on disk, over `episodes` from `first_episode` on.
RunConfiguration rowOf(const json& description, std::size_t index) {
  json row = description;
  RunConfiguration configuration;
  row.at("policy").get_to(configuration.policy);
  row.at("seed").get_to(configuration.protocol.seed);
  row.at("first_episode").get_to(configuration.protocol.first_episode);
  row.at("episodes").get_to(configuration.protocol.episodes);
  row.at("horizon").get_to(configuration.protocol.horizon);
  row.at("reference_simulator").get_to(configuration.reference);
  row.at("engine_simulator").get_to(configuration.engine);
  const json& knobs = row.at("rows").at(index);
  for (const pusht::two_mass::Knob& knob : pusht::two_mass::kKnobs) {
    configuration.knobs[knob.name] = knobs.at(knob.name);
  }
  return configuration;
}

/// "block_damp 2.0": the knobs that vary.
std::string settingText(const std::vector<pusht::TwoMassParameters>& rows, const pusht::TwoMassParameters& row) {
  std::string text;
  for (const pusht::two_mass::Knob& knob : pusht::two_mass::kKnobs) {
    const bool varies = std::any_of(rows.begin(), rows.end(), [&](const pusht::TwoMassParameters& other) {
      return other.*knob.value != rows.front().*knob.value;
    });
    if (varies || rows.size() == 1) {
      text += (text.empty() ? "" : ", ") + std::string(knob.name) + " " + pusht::shortestText(row.*knob.value);
    }
  }
  return text;
}

void printRow(const RunConfiguration& configuration, const std::string& setting, const Summary& summary) {
  std::cout << setting << ": " << displayName(configuration.engine) << " " << cell(summary.engine) << ", "
            << displayName(configuration.reference) << " " << cell(summary.reference) << ", divergence "
            << cell(summary.position_divergence, "m") << ", " << cell(summary.angle_divergence, "rad") << std::endl;
}

/// Runs one row after the other.
class Sweeper {
 public:
  Sweeper(const SweepOptions& options, const SweepPlan& plan, const Protocol& protocol, const Setup& setup,
          SweepFolder& folder, std::optional<SweepOnDisk> begun)
      : options_(options), plan_(plan), protocol_(protocol), setup_(setup), folder_(folder), begun_(std::move(begun)) {}

  void run() {
    const auto cached = options_.batch.references(setup_, protocol_.horizon);
    const ReferenceCache references =
        cached ? *cached : ReferenceCache(folder_.referencePath(), setup_.referenceKey(protocol_.horizon));
    const auto total = static_cast<int>(plan_.rows.size()) * static_cast<std::int64_t>(protocol_.episodes);
    ProgressBar bar("episodes", total);
    for (std::size_t row = 0; row < plan_.rows.size(); ++row) {
      const RunConfiguration configuration = rowConfiguration(protocol_, setup_.policyName(), plan_.rows[row]);
      std::optional<std::vector<EpisodeResult>> episodes = begun_ ? begun_->row(row, configuration) : std::nullopt;
      if (!episodes) {
        episodes = runRow(row, references, bar);
      } else {
        bar.skip(protocol_.episodes);
      }
      const Summary summary = summarize(*episodes);
      folder_.keep(configuration, *episodes);
      printRow(configuration, settingText(plan_.rows, plan_.rows[row]), summary);
    }
  }

 private:
  std::vector<EpisodeResult> runRow(std::size_t row, const ReferenceCache& references, ProgressBar& bar) {
    std::vector<EpisodeResult> episodes(protocol_.episodes);
    int finished = 0;
    const auto deliver = [&](const Episode& episode) {
      episodes.at(episode.index() - protocol_.first_episode) = episode.result();
      ++finished;
      bar.advance("row " + std::to_string(row + 1) + " of " + std::to_string(plan_.rows.size()));
    };
    runProtocol(protocol_, setup_.players(plan_.rows[row]), options_.batch.threadCount(), &references, deliver,
                interrupted);
    if (finished < protocol_.episodes) {
      throw pusht::RuntimeFault("interrupted in row " + std::to_string(row) + " of " +
                                std::to_string(plan_.rows.size()) + "; the same command goes on with it");
    }
    return episodes;
  }

  const SweepOptions& options_;
  const SweepPlan& plan_;
  const Protocol& protocol_;
  const Setup& setup_;
  SweepFolder& folder_;
  std::optional<SweepOnDisk> begun_;
};

/// Runs `body`; whatever its end, status.json tells it.
template <class Body>
void withStatus(SweepFolder& folder, const Body& body) {
  try {
    body();
  } catch (const std::exception& failure) {
    try {
      folder.finish(pusht::exitCodeOf(failure), failure.what());
    } catch (const pusht::RuntimeFault&) {
      // The first failure is the one to report.
    }
    throw;
  }
  folder.finish(pusht::ExitCode::kOk, "finished");
  std::cout << "results: " << folder.path().string() << std::endl;
}

/// What a shard is a part of.
json withoutShard(json description) {
  description.erase("shard");
  return description;
}

Shard shardOf(const SweepOnDisk& sweep) {
  const json shard = sweep.description().value("shard", json());
  if (!shard.is_string()) {
    throw pusht::BadDependency("shard " + sweep.folder().string() + ": is a sweep in one piece");
  }
  return Shard::from(shard.get<std::string>());
}

/// The shards by number. Throws BadDependency unless they are all those of one sweep.
std::map<int, SweepOnDisk> requireShards(const std::vector<std::string>& folders) {
  std::map<int, SweepOnDisk> shards;
  std::optional<SweepOnDisk> first;
  for (const std::string& folder : folders) {
    const SweepOnDisk sweep(folder);
    const Shard shard = shardOf(sweep);
    if (!first) {
      first = sweep;
    }
    std::string difference = firstDifference(withoutShard(sweep.description()), withoutShard(first->description()));
    if (difference.empty()) {
      difference =
          firstDifference(sweep.provenance().value("software", json()), first->provenance().value("software", json()));
    }
    if (difference.empty() && shard.of != shardOf(*first).of) {
      difference = "it is " + shard.text();
    }
    if (!difference.empty()) {
      throw pusht::BadDependency("shard " + folder + ": is of another sweep than " + first->folder().string() + ": " +
                                 difference);
    }
    const auto [place, is_new] = shards.emplace(shard.number, sweep);
    if (!is_new) {
      throw pusht::BadDependency("shards " + place->second.folder().string() + " and " + folder + ": are both " +
                                 shard.text());
    }
  }
  std::string missing;
  for (int number = 1; number <= shardOf(*first).of; ++number) {
    if (shards.count(number) == 0) {
      missing += (missing.empty() ? "" : ", ") + Shard{number, shardOf(*first).of}.text();
    }
  }
  if (!missing.empty()) {
    throw pusht::BadDependency("shards " + missing + ": are missing");
  }
  return shards;
}

/// The episodes of a row, from all shards.
std::vector<EpisodeResult> joinRow(const std::map<int, SweepOnDisk>& shards, const RunConfiguration& whole,
                                   std::size_t row) {
  std::vector<EpisodeResult> episodes;
  for (const auto& [number, sweep] : shards) {
    RunConfiguration part = whole;
    part.protocol = shardOf(sweep).share(whole.protocol);
    const auto found = sweep.row(row, part);
    if (!found) {
      throw pusht::BadDependency("shard " + sweep.folder().string() + ": row " + std::to_string(row) +
                                 " is not finished");
    }
    episodes.insert(episodes.end(), found->begin(), found->end());
  }
  return episodes;
}

}  // namespace

void SweepOptions::declare(CLI::App& app) {
  app.add_option("plan", plan, "YAML file: policy, seed, episodes, and a grid or a list of knob settings")->required();
  app.add_option("--shard", shard, "only a share of the episodes, for `merge`: I/N, e.g. 2/5");
  app.add_option("--out", out,
                 "folder for the results (default: the next free results/sweep-N); a sweep that it holds is gone on "
                 "with");
  app.add_flag("--overwrite", overwrite, "replace results that are in the folder already");
  batch.declare(app);
}

void sweep(const SweepOptions& options) {
  catchInterrupts();
  const SweepPlan plan = readSweepPlan(options.plan);
  const Shard shard = options.shard.empty() ? Shard() : Shard::from(options.shard);
  const Protocol protocol = shard.share(plan.protocol);
  SweepFolder folder(options.out, options.overwrite, "sweep");
  const Setup setup({plan.policy, true, plan.protocol.seed}, plan.scene);

  json description = descriptionOf(plan, setup);
  if (!options.shard.empty()) {
    description["shard"] = shard.text();
  }
  json origin = setup.provenance(rowConfiguration(protocol, setup.policyName(), plan.rows.front()));
  origin.erase("configuration");
  std::optional<SweepOnDisk> begun = folder.begin(description, origin);
  withStatus(folder, [&] { Sweeper(options, plan, protocol, setup, folder, std::move(begun)).run(); });
  if (options.shard.empty()) {  // the other shards may have the successes
    warn(doubtAboutPolicy(folder.rows().front()));
  }
  std::error_code ignored;
  fs::remove_all(folder.referencePath(), ignored);
}

void MergeOptions::declare(CLI::App& app) {
  app.add_option("shards", shards, "folders of all shards of a sweep")->required();
  app.add_option("--out", out, "folder for the results (default: the next free results/merge-N)");
  app.add_flag("--overwrite", overwrite, "replace results that are in the folder already");
}

void merge(const MergeOptions& options) {
  const std::map<int, SweepOnDisk> shards = requireShards(options.shards);
  const json description = withoutShard(shards.begin()->second.description());
  const json& provenance = shards.begin()->second.provenance();
  SweepFolder folder(options.out, options.overwrite, "merge");
  folder.begin(description, provenance);
  withStatus(folder, [&] {
    for (std::size_t row = 0; row < description.at("rows").size(); ++row) {
      const RunConfiguration configuration = rowOf(description, row);
      folder.keep(configuration, joinRow(shards, configuration, row));
    }
  });
  warn(doubtAboutPolicy(folder.rows().front()));
}

}  // namespace sim2sim
