// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/sweep.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/shard.hpp"
#include "sim2sim_eval/batch/sweep_folder.hpp"
#include "sim2sim_eval/batch/sweep_plan.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/attribution.hpp"
#include "sim2sim_protocol/results/attribution_files.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"
#include "sim2sim_protocol/results/table.hpp"
#include "sim2sim_protocol/runner.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// All rows as they run, whatever their engine.
RunConfiguration sweepConfiguration(const Protocol& protocol, const LoadedRun& loaded) {
  RunConfiguration configuration;
  configuration.protocol = protocol;
  configuration.policy = loaded.policyName();
  configuration.reference = loaded.reference().record();
  return configuration;
}

/// The run that a row is.
RunConfiguration rowConfiguration(const Protocol& protocol, const LoadedRun& loaded, const LoadedSimulator& engine) {
  RunConfiguration configuration = sweepConfiguration(protocol, loaded);
  configuration.engine = engine.record();
  return configuration;
}

/// Description of a sweep for sweep.json: all that decides it, equal for all its shards. `engines`: records by row.
json descriptionOf(const SweepPlan& plan, const LoadedRun& loaded, const json& engines) {
  json description = describe(sweepConfiguration(plan.protocol, loaded));
  for (const char* of_a_row : {"engine_simulator", "knobs", "simulators", "config_hash"}) {
    description.erase(of_a_row);
  }
  description["inputs"] = loaded.identity();
  description["rows"] = engines;
  if (plan.sample) {
    description["permutations"] = toJson(*plan.sample);
  }
  return description;
}

/// Names of parameters that have more than one value, which tell the rows apart. All names for a single row.
std::vector<std::string> varyingParameters(const std::vector<SimulatorChoice>& rows) {
  std::vector<std::string> varying;
  for (const SimulatorChoice& row : rows) {
    for (const pusht::Parameter& parameter : row.parameters) {
      const bool varies = std::any_of(rows.begin(), rows.end(), [&](const SimulatorChoice& other) {
        return &other.kind.get() == &row.kind.get() && other.parameters.at(parameter.name()).value != parameter.value;
      });
      const bool is_new = std::find(varying.begin(), varying.end(), parameter.name()) == varying.end();
      if (is_new && (varies || rows.size() == 1)) {
        varying.push_back(parameter.name());
      }
    }
  }
  return varying;
}

bool hasSeveralKinds(const std::vector<SimulatorChoice>& rows) {
  return std::any_of(rows.begin(), rows.end(),
                     [&](const SimulatorChoice& row) { return &row.kind.get() != &rows.front().kind.get(); });
}

void printRow(const RunConfiguration& configuration, const std::string& parameters, const Summary& summary) {
  std::cout << parameters << ": " << configuration.engine.title << " " << cell(summary.engine) << ", "
            << configuration.reference.title << " " << cell(summary.reference) << ", divergence "
            << divergences(summary, ", ") << std::endl;
}

/// Runs one row after the other.
class Sweeper {
 public:
  Sweeper(const SweepOptions& options, const SweepPlan& plan, const Protocol& protocol, const LoadedRun& loaded,
          SweepFolder& folder)
      : options_(options),
        plan_(plan),
        protocol_(protocol),
        loaded_(loaded),
        folder_(folder),
        varying_(varyingParameters(plan.rows)),
        bar_("episodes", static_cast<std::int64_t>(plan.rows.size()) * protocol.episodes) {}

  /// Throws RuntimeFault if it is interrupted, or at the end if there were rows that failed.
  void run() {
    const auto cached = options_.batch.references(loaded_, protocol_);
    if (!cached) {
      folder_.removeReference();  // of an attempt that was cut short, perhaps in the midst of a file
    }
    const ReferenceCache references =
        cached ? *cached : ReferenceCache(folder_.referencePath(), loaded_.referenceKey(protocol_));
    std::size_t failures = 0;
    std::string first_failure;
    for (std::size_t index = 0; index < plan_.rows.size(); ++index) {
      try {
        finishRow(index, references);
      } catch (const pusht::SimulationFault& fault) {  // other parameters may do better
        first_failure = ++failures == 1 ? fault.what() : first_failure;
      }
    }
    if (failures > 0) {
      throw pusht::RuntimeFault(std::to_string(failures) + " of " + std::to_string(plan_.rows.size()) +
                                " rows failed, first " + first_failure);
    }
    if (!cached) {
      folder_.removeReference();
    }
  }

 private:
  void finishRow(std::size_t index, const ReferenceCache& references) {
    const LoadedSimulator engine(plan_.rows[index]);
    const RunConfiguration configuration = rowConfiguration(protocol_, loaded_, engine);
    std::optional<SweepRow> row = readRow(folder_.path(), index, configuration);
    if (row) {
      bar_.skip(protocol_.episodes);
      folder_.resume(index, row->metrics);
    } else {
      row.emplace(configuration, runRow(index, engine, configuration, references));
      folder_.keep(index, configuration, *row);
    }
    printRow(configuration, parametersText(index), row->summary);
  }

  std::vector<EpisodeResult> runRow(std::size_t index, const LoadedSimulator& engine,
                                    const RunConfiguration& configuration, const ReferenceCache& references) {
    Journal journal = folder_.journal(index, configuration);
    std::vector<EpisodeResult> episodes(protocol_.episodes);
    int finished = 0;
    const auto take = [&](const EpisodeResult& result) {
      episodes.at(result.index - protocol_.first_episode) = result;
      ++finished;
    };
    for (const FinishedEpisode& episode : journal.kept()) {
      take(episode.result);
    }
    bar_.skip(finished);
    const auto deliver = [&](const Episode& episode) {
      const EpisodeResult result = episode.result();
      journal.add({result});
      take(result);
      bar_.advance(rowText(index, plan_.rows.size()));
    };
    try {
      runProtocol(protocol_, loaded_.workerFactory(engine), options_.batch.threadCount(), &references, deliver,
                  interrupted, journal.keptIndices());
    } catch (pusht::Error& error) {
      if (dynamic_cast<const pusht::SimulationFault*>(&error) != nullptr) {
        journal.remove();  // the row cannot be finished
        std::error_code not_empty;
        fs::remove(rowFolder(folder_.path(), index), not_empty);
      }
      error.addContext("row " + std::to_string(index) + " (" + parametersText(index) + ")");
      throw;
    }
    if (finished < protocol_.episodes) {
      throw pusht::RuntimeFault("interrupted in " + rowText(index, plan_.rows.size()) + ", after " +
                                std::to_string(finished) + " of its " + std::to_string(protocol_.episodes) +
                                " episodes; to continue, run the same command with --out " + folder_.path().string() +
                                (options_.overwrite ? " and without --overwrite" : ""));
    }
    return episodes;
  }

  /// "block_damp 2.0"; with the kind in front if there are several
  std::string parametersText(std::size_t index) const {
    const SimulatorChoice& row = plan_.rows[index];
    std::string text = hasSeveralKinds(plan_.rows) ? row.kind.get().name : "";
    for (const pusht::Parameter& parameter : row.parameters) {
      if (std::find(varying_.begin(), varying_.end(), parameter.name()) != varying_.end()) {
        text += (text.empty() ? "" : ", ") + parameter.name() + " " + pusht::textOf(parameter.value);
      }
    }
    return text;
  }

  const SweepOptions& options_;
  const SweepPlan& plan_;
  const Protocol& protocol_;
  const LoadedRun& loaded_;
  SweepFolder& folder_;
  std::vector<std::string> varying_;
  ProgressBar bar_;
};

}  // namespace

void SweepOptions::declare(CLI::App& app) {
  app.add_option("plan", plan, "YAML file: policy, seed, episodes, and a grid or a list of knob settings")
      ->required()
      ->check(notEmpty());
  app.add_option("--episodes", episodes, "number of episodes, instead of the plan's")
      ->check(decimalInteger() & CLI::PositiveNumber);
  app.add_option("--shard", shard, "only a share of the episodes, for `merge`: I/N, e.g. 2/5")->check(notEmpty());
  app.add_option("--out", out,
                 "folder for the results (default: the next free results/sweep-N); if it holds this sweep already, the "
                 "sweep continues")
      ->check(notEmpty());
  app.add_flag("--overwrite", overwrite, "replace results that are in the folder already");
  batch.declare(app);
}

void sweep(const SweepOptions& options) {
  SweepPlan plan = readSweepPlan(options.plan);
  if (options.episodes > 0) {
    plan.protocol.episodes = options.episodes;
    plan.protocol.validate();
  }
  plan.protocol.initial_states = givenInitialStates(plan.starts, plan.protocol.first_episode, plan.protocol.episodes);
  const Shard shard = options.shard.empty() ? Shard() : Shard::from(options.shard);
  const Protocol protocol = shard.share(plan.protocol);
  SweepFolder folder(options.out, options.overwrite, "sweep");
  folder.refuseInputs({{"plan", options.plan},
                       {"policy", plan.policy},
                       {"starts", plan.starts},
                       {"reference cache", options.batch.reference_cache}});
  const LoadedRun loaded = loadFor(folder, [&] {
    return LoadedRun({plan.policy, true, plan.protocol.seed}, plan.reference, plan.rows);
  });
  folder.refuseInputs(loaded.reference().inputs());
  json engines = json::array();
  for (const SimulatorChoice& row : plan.rows) {
    const LoadedSimulator engine(row);
    folder.refuseInputs(engine.inputs());
    engines.push_back(json(toJson(engine.record())));
  }
  const LoadedSimulator first(plan.rows.front());

  json description = descriptionOf(plan, loaded, engines);
  if (!options.shard.empty()) {
    description["shard"] = shard.text();
  }
  json origin = loaded.provenance(rowConfiguration(protocol, loaded, first), first);
  origin["format"] = description.at("format");
  for (const char* of_a_row : {"configuration", "engine"}) {
    origin.erase(of_a_row);
  }
  folder.begin(description, origin);
  withStatus(folder, [&] { Sweeper(options, plan, protocol, loaded, folder).run(); });
  if (options.shard.empty()) {  // the other shards may have the successes
    warn(doubtAboutPolicy(folder.rows().front(), origin));
  }
}

}  // namespace sim2sim
