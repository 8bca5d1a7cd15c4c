// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "batch/loaded_plan.hpp"
#include "batch/requirements.hpp"
#include "batch/shard.hpp"
#include "batch/sweep_description.hpp"
#include "batch/sweep_folder.hpp"
#include "batch/sweep_plan.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_eval/batch/batch_options.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/model_variants.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"
#include "sim2sim_protocol/results/table.hpp"
#include "sim2sim_protocol/runner.hpp"
#include "sim2sim_serving/peer.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Command line of `sweep`.
struct SweepOptions {
  std::string plan;   ///< YAML file for readSweepPlan()
  int episodes = 0;   ///< number of episodes instead of the plan's; 0: the plan's
  std::string shard;  ///< "I/N"; empty: the whole sweep
  std::string out;    ///< results folder; empty: the next free results/sweep-N
  bool overwrite = false;
  RequirementOptions required;  ///< besides those of the plan
  BatchOptions batch;
};

/// Names of parameters that have more than one value, which tell the rows apart. All names for a single row.
std::vector<std::string> varyingParameters(const std::vector<PlannedRow>& rows) {
  std::vector<std::string> varying;
  for (const PlannedRow& row : rows) {
    for (const std::string& name : row.engine.names()) {
      const bool varies = std::any_of(rows.begin(), rows.end(), [&](const PlannedRow& other) {
        return &other.engine.kind.get() == &row.engine.kind.get() &&
               other.engine.at(name).value != row.engine.at(name).value;
      });
      const bool is_new = std::find(varying.begin(), varying.end(), name) == varying.end();
      if (is_new && (varies || rows.size() == 1)) {
        varying.push_back(name);
      }
    }
  }
  return varying;
}

bool hasSeveralKinds(const std::vector<PlannedRow>& rows) {
  return std::any_of(rows.begin(), rows.end(),
                     [&](const PlannedRow& row) { return &row.engine.kind.get() != &rows.front().engine.kind.get(); });
}

void printRow(std::ostream& out, const RunConfiguration& configuration, const std::string& parameters,
              const Summary& summary) {
  out << parameters << ": " << configuration.engine.title << " " << cell(summary.engine) << ", "
      << configuration.reference.title << " " << cell(summary.reference) << ", divergence "
      << divergences(summary, ", ") << std::endl;
}

/// Runs one row after the other.
class Sweeper {
 public:
  Sweeper(const SweepOptions& options, const SweepPlan& plan, const Protocol& protocol,
          const std::vector<LoadedRun>& loaded, const std::vector<Requirement>& requirements, SweepFolder& folder,
          const CommandHost& host)
      : options_(options),
        plan_(plan),
        protocol_(protocol),
        loaded_(loaded),
        folder_(folder),
        requirements_(requirements),
        out_(*host.out),
        varying_(varyingParameters(plan.rows)),
        bar_("episodes", static_cast<std::int64_t>(plan.rows.size()) * protocol.episodes, host.progress) {}

  /// Answers to the requirements, row by row.
  const std::vector<RequirementResult>& answers() const { return answers_; }

  /// Throws RuntimeFault if it is interrupted, or at the end if there were rows that failed.
  void run() {
    const bool keeps_references = options_.batch.references(loaded_.front(), protocol_).has_value();
    if (!keeps_references) {
      folder_.removeReference();  // of an attempt that was cut short, perhaps in the midst of a file
    }
    std::size_t failures = 0;
    std::string first_failure;
    const auto count = [&](const pusht::Error& fault) {
      first_failure = ++failures == 1 ? fault.what() : first_failure;
    };
    for (std::size_t index = 0; index < plan_.rows.size(); ++index) {
      try {
        finishRow(index);
      } catch (const pusht::SimulationFault& fault) {  // other parameters may do better
        count(fault);
      } catch (const pusht::NodeMissing& fault) {  // it may come back, and the row goes on another time
        requireNotInterrupted("in " + rowText(index, plan_.rows.size()));
        count(fault);
      }
      if (!keeps_references && failures == 0 && isLastOfPolicy(index)) {
        folder_.removeReference();
      }
    }
    if (failures > 0) {
      throw pusht::RuntimeFault(std::to_string(failures) + " of " + std::to_string(plan_.rows.size()) +
                                " rows failed, first " + first_failure);
    }
  }

 private:
  bool isLastOfPolicy(std::size_t index) const {
    return index + 1 == plan_.rows.size() || plan_.rows[index + 1].policy != plan_.rows[index].policy;
  }

  const LoadedRun& runOf(std::size_t index) const { return loaded_[plan_.rows[index].policy]; }

  ReferenceCache referencesOf(std::size_t index) const {
    const LoadedRun& run = runOf(index);
    return options_.batch.references(run, protocol_)
        .value_or(ReferenceCache(folder_.referencePath(), run.referenceKey(protocol_)));
  }

  void finishRow(std::size_t index) {
    const LoadedSimulator engine(plan_.rows[index].engine);
    const RunConfiguration configuration = rowConfiguration(protocol_, runOf(index), engine);
    std::optional<SweepRow> row = readRow(folder_.path(), index, configuration);
    if (row) {
      bar_.skip(protocol_.episodes);
      folder_.resume(index, row->metrics);
    } else {
      row.emplace(configuration, runRow(index, engine, configuration));
      folder_.keep(index, configuration, *row);
    }
    bar_.clear();
    printRow(out_, configuration, parametersText(index), row->summary);
    for (const Requirement& requirement : requirements_) {
      RequirementResult answer = judge(requirement, protocol_, row->summary);
      answer.requirement.insert(0, "row " + std::to_string(index) + " (" + parametersText(index) + "), ");
      answers_.push_back(answer);
    }
  }

  std::vector<EpisodeResult> runRow(std::size_t index, const LoadedSimulator& engine,
                                    const RunConfiguration& configuration) {
    const ReferenceCache references = referencesOf(index);
    Journal journal = folder_.journal(index, configuration);
    std::vector<EpisodeResult> episodes(protocol_.episodes);
    int finished = 0;
    const auto take = [&](const EpisodeResult& result) {
      EpisodeResult& kept = episodes.at(result.index - protocol_.first_episode) = result;
      for (RolloutResult& rollout : kept.rollouts) {
        rollout.limited_commands.reset();  // as in a row that is read back
      }
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
      runProtocol(protocol_, runOf(index).workerFactory(engine), options_.batch.threadCount(), &references, deliver,
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

  /// "block_damp 2.0"; in front the policy if the plan lists policies, and the kind if there are several
  std::string parametersText(std::size_t index) const {
    const SimulatorChoice& engine = plan_.rows[index].engine;
    std::string text = plan_.lists_policies ? runOf(index).policyName() : "";
    if (hasSeveralKinds(plan_.rows)) {
      text += (text.empty() ? "" : ", ") + engine.name();
    }
    for (const std::string& name : engine.names()) {
      if (std::find(varying_.begin(), varying_.end(), name) != varying_.end()) {
        text += (text.empty() ? "" : ", ") + name + " " + pusht::textOf(engine.at(name).value);
      }
    }
    return text;
  }

  const SweepOptions& options_;
  const SweepPlan& plan_;
  const Protocol& protocol_;
  const std::vector<LoadedRun>& loaded_;  // by policy of the plan
  SweepFolder& folder_;
  const std::vector<Requirement>& requirements_;
  std::ostream& out_;
  std::vector<RequirementResult> answers_;  // of each finished row
  std::vector<std::string> varying_;
  ProgressBar bar_;
};

/// Names the default model variants. Throws InvalidInput as sim2sim::nameVariants(), or if they are not the same for
/// all references.
void nameVariants(SweepPlan& plan) {
  const Protocol asked = plan.protocol;
  for (const PlannedPolicy& policy : plan.policies) {
    Protocol named = asked;
    nameVariants(policy.reference.kind, policy.reference.parameters, named);
    if (&policy == &plan.policies.front()) {
      plan.protocol = named;
    }
    if (variantsOf(named) != variantsOf(plan.protocol)) {
      throw pusht::InvalidInput("model variants: of policy " + policy.policy + " they would be " +
                                pusht::joined(variantsOf(named)) + ", of the first one " +
                                pusht::joined(variantsOf(plan.protocol)) + "; must be the same, so name them");
    }
  }
}

/// Throws RuntimeFault if policies were `refused`, and are not in the plan any more.
void requireNoneLeftOut(const SweepPlan& plan, const std::vector<std::string>& refused) {
  if (!refused.empty()) {
    throw pusht::RuntimeFault(std::to_string(refused.size()) + " of " +
                              std::to_string(refused.size() + plan.policies.size()) +
                              " policies were left out, first " + refused.front());
  }
}

/// Requirements of each row: those of the plan, and of the command line. A shard, which is not a whole row, has none of
/// the plan's.
std::vector<Requirement> requirementsOf(const SweepOptions& options, const SweepPlan& plan) {
  RequirementOptions required = options.required;
  if (options.shard.empty()) {
    required.texts.insert(required.texts.begin(), plan.required.begin(), plan.required.end());
  } else if (!required.texts.empty()) {
    throw pusht::InvalidInput("require: must stand without --shard, as a shard is no whole row");
  }
  std::vector<Requirement> requirements = required.read();
  for (const Requirement& requirement : requirements) {
    requirement.requireOneRun(std::nullopt);
  }
  return requirements;
}

/// Runs all rows of a plan over the same episodes, or continues an unfinished sweep: rows in the folder are not run
/// again. The reference is simulated once for all rows. A row whose simulation fails is left out, and the others run.
/// Throws InvalidInput for a bad plan, RuntimeFault if it was interrupted or a row has failed; finished rows are kept
/// then. Returns the folder of the results.
json sweep(const SweepOptions& options, const CommandHost& host) {
  SweepPlan plan = readSweepPlan(options.plan);
  const std::vector<Requirement> requirements = requirementsOf(options, plan);
  if (options.episodes > 0) {
    plan.protocol.episodes = options.episodes;
    plan.protocol.validate();
  }
  nameVariants(plan);
  plan.protocol.initial_states = givenInitialStates(plan.starts, plan.protocol.firstStart(), plan.protocol.starts(),
                                                    plan.protocol.overlapping_starts, plan.protocol.runTask());
  const Shard shard = options.shard.empty() ? Shard() : Shard::from(options.shard);
  const Protocol protocol = shard.share(plan.protocol);
  SweepFolder folder(options.out, options.overwrite, "sweep");
  std::vector<Input> inputs = {
      {"plan", options.plan}, {"starts", plan.starts}, {"reference cache", options.batch.reference_cache}};
  for (const PlannedPolicy& policy : plan.policies) {
    inputs.push_back({"policy", policy.policy});
  }
  folder.refuseInputs(inputs);
  std::vector<std::string> refused;
  const std::vector<LoadedRun> loaded = loadFor(folder, [&] { return loadAll(plan, !options.shard.empty(), refused); });
  for (const LoadedRun& run : loaded) {
    folder.refuseInputs(run.reference().inputs());
  }
  std::vector<SimulatorRecord> engines;
  for (const PlannedRow& row : plan.rows) {
    const LoadedSimulator engine(row.engine);
    folder.refuseInputs(engine.inputs());
    engines.push_back(engine.record());
  }
  json description = describe(plan, loaded, engines);
  if (!options.shard.empty()) {
    description["shard"] = shard.text();
  }
  const json origin = provenanceOf(plan, protocol, loaded);
  folder.begin(description, origin);
  Sweeper sweeper(options, plan, protocol, loaded, requirements, folder, host);
  try {
    withStatus(folder, *host.out, [&] {
      sweeper.run();
      requireNoneLeftOut(plan, refused);
    });
  } catch (const pusht::Error&) {
    report("sweep", options.required, sweeper.answers(), *host.out);
    throw;
  }
  if (!options.shard.empty() && !plan.required.empty()) {
    *host.out << "require: is not asked of a shard\n";
  }
  if (!plan.lists_policies) {
    const LoadedSimulator engine(plan.rows.front().engine);
    const RunConfiguration first = rowConfiguration(protocol, loaded.front(), engine);
    if (const std::string note = noteOnNoise(first, origin); !note.empty()) {
      *host.out << note << std::endl;
    }
  }
  if (options.shard.empty() && !plan.lists_policies) {  // the other shards may have the successes
    warn(doubtAboutPolicy(folder.rows().front(), origin));
  }
  report("sweep", options.required, sweeper.answers(), *host.out);
  requireAllMet(sweeper.answers());
  return {{"folder", folder.path().string()}};
}

}  // namespace

CommandWork sweepCommand(CLI::App& app) {
  const auto options = std::make_shared<SweepOptions>();
  app.description("Runs the comparison for many settings of the engine's parameters, over the same episodes.");
  app.add_option("plan", options->plan,
                 "YAML file: policies, seed, episodes, and a grid or a list of parameter settings")
      ->required()
      ->check(notEmpty());
  app.add_option("--episodes", options->episodes, "number of episodes, instead of the plan's")
      ->check(decimalInteger() & CLI::PositiveNumber);
  app.add_option("--shard", options->shard, "only a share of the episodes, for `merge`: I/N, e.g. 2/5")
      ->check(notEmpty());
  app.add_option("--out", options->out,
                 "folder for the results (default: the next free results/sweep-N); if it holds this sweep already, the "
                 "sweep continues")
      ->check(notEmpty());
  app.add_flag("--overwrite", options->overwrite, "replace results that are in the folder already");
  options->required.declare(app);
  options->batch.declare(app);
  return [options](const CommandHost& host) { return sweep(*options, host); };
}

int sweepMain(int argc, char** argv) { return runCommand("sweep", sweepCommand, argc, argv); }

}  // namespace sim2sim
