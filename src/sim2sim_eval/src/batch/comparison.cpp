// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/comparison.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "bag/messages.hpp"
#include "bag/run_bag.hpp"
#include "batch/requirements.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/loaded_run.hpp"
#include "sim2sim_eval/batch/simulators.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/model_variants.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/run.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_protocol/results/traces.hpp"
#include "sim2sim_protocol/runner.hpp"
#include "sim2sim_serving/installed_file.hpp"
#include "sim2sim_serving/remote_simulator.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;

/// Writes a run into its bag, one finished episode after the other.
class Recorder {
 public:
  Recorder(const fs::path& path, const nlohmann::ordered_json& provenance)
      : bag_(path, provenance, defaultWorldNames(), nextStamp()) {}

  void record(const Episode& episode, const EpisodeResult& result, const Run& run) {
    ros::Time stamp;
    for (int step = 0; step <= episode.steps(); ++step) {
      stamp = nextStamp();
      bag_.writeWorlds(episode, step, stamp);
      bag_.write(divergenceMessage(episode, step, stamp));
    }
    const Protocol& protocol = run.configuration().protocol;
    bag_.writeProbes(protocol, episode, stamp);
    bag_.write(toMessage(protocol, result, stamp));
    bag_.write(summaryMessage(run.configuration(), run.summary(), stamp));
  }

  void finish() { bag_.finish(); }

 private:
  ros::Time nextStamp() {
    stamps_.advance();
    return stamps_.now();
  }

  pusht::StampSource stamps_;
  RunBag bag_;
};

/// The starts of a run, as a file for readInitialStates().
std::string startsOf(const Protocol& protocol) {
  std::vector<pusht::WorldState> states;
  for (int episode = protocol.first_episode; episode <= protocol.lastEpisode(); episode += protocol.repeats) {
    states.push_back(protocol.initialState(episode));
  }
  return initialStatesCsv(states);
}

/// Throws InvalidInput if there is something at `path` already. A run that goes on may have written it before.
void requireNewStarts(const fs::path& path, const Protocol& protocol, bool goes_on) {
  std::error_code ignored;
  const bool written_before = goes_on && fs::is_regular_file(fs::symlink_status(path, ignored)) &&
                              pusht::readFile(path, "write_starts") == startsOf(protocol);
  if (!written_before) {
    pusht::requireNewFile("write_starts", path);
  }
}

/// Declares parameters of a kind of the course as options of their own, those in `names` or all; none if the kind
/// cannot be loaded.
void declareShortForms(CLI::App& app, const std::string& kind, const std::set<std::string>& names,
                       std::vector<std::string>& parameters) {
  const pusht::SimulatorKind* const known = pusht::SimulatorKinds::installed().find(kind);
  if (known == nullptr) {
    return;  // why, is said when it is chosen
  }
  for (const pusht::ParameterDescriptor& parameter : known->parameters) {
    if (!names.empty() && names.count(parameter.name) == 0) {
      continue;
    }
    const std::string unit = parameter.unit.empty() ? "" : " [" + parameter.unit + "]";
    const bool is_real = std::holds_alternative<double>(parameter.default_value);
    app.add_option_function<std::string>(
           "--" + parameter.name,
           [&parameters, name = parameter.name](const std::string& value) {
             parameters.push_back(std::string(name).append("=").append(value));
           },
           known->title + ": " + parameter.meaning + unit)
        ->check(is_real ? decimalReal() : CLI::Validator(""))
        ->default_str(pusht::textOf(parameter.default_value));
  }
}

/// Throws InvalidInput if an option asks for a file in the folder of the results, and there is none.
void requireNoFiles(const CompareOptions& options) {
  const auto refuse = [](const char* option, bool given) {
    if (given) {
      throw pusht::InvalidInput(std::string(option) + ": must be left out without out, the folder of the results");
    }
  };
  refuse("record", options.record);
  refuse("traces", options.traces);
  refuse("overwrite", options.overwrite);
}

/// Throws InvalidInput for an option of the engine, where there is none.
void requireNothingOfAnEngine(const CompareOptions& options) {
  const std::vector<std::string>& of_reference = options.reference_parameters;
  for (const std::string& setting : options.engine_parameters) {
    const bool is_of_both = setting.rfind(pusht::kLoopPrefix, 0) == 0 &&  // --loop
                            std::find(of_reference.begin(), of_reference.end(), setting) != of_reference.end();
    if (!is_of_both) {
      throw pusht::InvalidInput("setting '" + setting + "' of the engine: must be left out with engine none");
    }
  }
  if (options.record) {
    throw pusht::InvalidInput("record: must be left out with engine none, as a bag has two simulators");
  }
}

/// What to do after an interruption, as a clause behind the message; empty if there is nothing to continue.
std::string adviceAfterInterruption(const CompareOptions& options, const ComparisonHost& host,
                                    const RunFolder* folder) {
  if (folder == nullptr || !host.can_return) {
    return "";
  }
  return std::string("; ") +
         (options.goesOn() ? "to continue, run the same command with --out "
                           : "a run with --record or --traces begins again: --overwrite --out ") +
         folder->path().string() + (options.goesOn() && options.overwrite ? " and without --overwrite" : "");
}

}  // namespace

void CompareOptions::declare(CLI::App& app) {
  app.add_option(
         "--policy", policy,
         "TorchScript file, or ONNX file NAME.onnx (observation[10] to action[2]), 'bc' for the shipped policy, "
         "'expert', 'planner', or 'fresh-untrained'")
      ->capture_default_str();
  CLI::Option* const require =
      app.add_flag("--require-policy", require_policy,
                   "the shipped policy must be there, too: without it an untrained one runs, with a warning");
  CLI::Option* const allow =
      app.add_flag("--allow-untrained", allow_untrained,
                   "run an untrained policy, with a warning, in place of a named file that is not there");
  sim2sim::declare(app, protocol);
  app.get_option("--episodes")->each([this](const std::string& /*text*/) { episodes_given = true; });
  app.add_option("--starts", starts,
                 "CSV file with the start of each episode, instead of spawn seeds: columns as the fields of "
                 "WorldState.msg; velocities may be left out")
      ->check(notEmpty());
  app.add_option("--write-starts", write_starts, "write the starts of the run into a new CSV file, for --starts")
      ->check(notEmpty());
  app.add_option("--reference", reference,
                 "kind of simulator: " + pusht::joined(pusht::SimulatorKinds::installed().names()) +
                     "; or node:/NAME, what that node serves")
      ->capture_default_str();
  app.add_option("--engine", engine,
                 "kind of simulator that is compared with the reference; none: success in the reference alone")
      ->capture_default_str();
  app.add_option("--set", engine_parameters, "NAME=VALUE: a parameter of the engine; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--set-reference", reference_parameters, "NAME=VALUE: a parameter of the reference; may be repeated")
      ->allow_extra_args(false);
  declareLoop(app, reference_parameters, engine_parameters);
  declareShortForms(app, kCourseEngine, {}, engine_parameters);
  declareShortForms(app, kCourseReference, {"scene"}, reference_parameters);
  app.add_flag("--smoke", smoke, "short fixed run of an untrained policy, whatever --policy says: 2 episodes, 40 steps")
      ->excludes(require)
      ->excludes(allow);
  app.add_option(
         "--out", out,
         "folder for the results (default: the next free results/compare-N); if it holds this run, unfinished, the "
         "run continues, unless it has --record or --traces")
      ->check(notEmpty());
  app.add_flag("--overwrite", overwrite, "replace results that are in the folder already");
  app.add_flag("--record", record, "write the run into compare.bag");
  app.add_flag("--traces", traces, "write what the worlds did into traces.npy, for `report` and for NumPy");
  batch.declare(app);
}

ComparisonResults compare(const CompareOptions& options, const ComparisonHost& host) {
  // Checks of all inputs come before the first file is written.
  RunConfiguration configuration;
  if (options.smoke && &options.protocol.runTask() != &pusht::fullCircle()) {
    throw pusht::InvalidInput("task " + options.protocol.task +
                              ": must be left out for a smoke run, whose policy is of " + pusht::fullCircle().name);
  }
  configuration.protocol = options.smoke ? smokeRun(options.protocol) : options.protocol;
  if (!options.smoke && !options.episodes_given) {
    configuration.protocol.episodes = defaultEpisodes(configuration.protocol, options.starts);
  }
  configuration.smoke = options.smoke;
  if (options.engine == kNoEngine) {
    requireNothingOfAnEngine(options);
    configuration.protocol.alone = true;
    configuration.protocol.floor = false;  // of divergences
  }
  configuration.protocol.carryTask();
  configuration.protocol.validate();
  configuration.protocol.initial_states =
      givenInitialStates(options.starts, configuration.protocol.firstStart(), configuration.protocol.starts(),
                         configuration.protocol.overlapping_starts, configuration.protocol.runTask());
  SimulatorChoice reference = chooseSimulator(options.reference, options.reference_parameters);
  SimulatorChoice chosen_engine =
      configuration.protocol.alone ? noEngine() : chooseSimulator(options.engine, options.engine_parameters);
  setTask(configuration.protocol.runTask(), {reference, chosen_engine});
  requireTwoWorlds(reference, chosen_engine);
  nameVariants(reference.kind, reference.parameters, configuration.protocol);
  std::error_code ignored;
  if (!options.write_starts.empty() &&
      fs::weakly_canonical(options.write_starts, ignored) == fs::weakly_canonical(options.out, ignored)) {
    throw pusht::InvalidInput("write_starts " + options.write_starts + ": must not be the folder of the results");
  }
  std::optional<RunFolder> folder;
  if (host.files) {
    folder.emplace(options.out, options.overwrite, "compare", options.goesOn() && host.can_return);
  } else {
    requireNoFiles(options);
  }
  const auto refuse_inputs = [&folder](const std::vector<Input>& inputs) {
    if (folder) {
      folder->refuseInputs(inputs);
    }
  };
  requireNewStarts(options.write_starts, configuration.protocol, folder && folder->takesUp());
  refuse_inputs({{"policy", host.choose_policy ? "" : options.policy},
                 {"reference cache", options.batch.reference_cache},
                 {"starts", options.starts},
                 {"write_starts", options.write_starts}});
  const LoadedSimulator engine(chosen_engine);
  const auto choose_policy = [&] {
    return pusht::choosePolicy({options.smoke ? pusht::kUntrainedPolicy : options.policy, options.require_policy,
                                configuration.protocol.seed, options.allow_untrained, configuration.protocol.runTask()},
                               pusht::installedFile("pusht_policy", pusht::kShippedCheckpoint), interrupted);
  };
  const auto load = [&] {
    return LoadedRun(host.choose_policy ? host.choose_policy : choose_policy, reference, {chosen_engine},
                     configuration.protocol);
  };
  const LoadedRun loaded = folder ? loadFor(*folder, load) : load();
  refuse_inputs(loaded.reference().inputs());
  refuse_inputs(engine.inputs());
  configuration.reference = loaded.reference().record();
  configuration.engine = engine.record();
  configuration.policy = loaded.policyName();
  const auto references = options.batch.references(loaded, configuration.protocol);

  const nlohmann::ordered_json origin = loaded.provenance(configuration, engine);
  nlohmann::json identity = {
      {"configuration", describe(configuration)}, {"inputs", loaded.identity()}, {"machine_code", origin.at("code")}};
  identity["configuration"].erase("config_hash");  // it follows from the rest
  Run run(configuration, folder ? &*folder : nullptr, origin, identity);
  try {
    const bool goes_on =
        folder && folder->takesUp();  // the starts may be written: requireNewStarts() has compared them
    if (!options.write_starts.empty() && !(goes_on && fs::exists(options.write_starts))) {
      pusht::writeNewFile("write_starts", options.write_starts, startsOf(configuration.protocol));
    }
    std::optional<Recorder> recorder;
    if (options.record) {
      recorder.emplace(folder->bagPath(), origin);
    }
    std::optional<TraceFile> traces;
    if (options.traces) {
      traces.emplace(folder->tracesPath());
    }
    ProgressBar bar("episodes", configuration.protocol.episodes, host.progress);
    int reference_successes = 0;
    int engine_successes = 0;
    const auto count = [&](const EpisodeResult& result) {
      reference_successes += result.rollouts[kReferenceClosed].success ? 1 : 0;
      engine_successes += result.rollouts[kEngineClosed].success ? 1 : 0;
    };
    std::set<int> finished;  // before an interruption
    for (const EpisodeResult& result : run.episodes()) {
      count(result);
      finished.insert(result.index);
    }
    bar.skip(static_cast<std::int64_t>(finished.size()));
    std::atomic<bool> decided = run.decided();
    const auto take = [&](const Episode& episode) {
      const EpisodeResult result = run.add(episode);
      if (recorder) {
        recorder->record(episode, result, run);
      }
      if (traces) {
        traces->add(episode);
      }
      count(result);
      bar.advance("success " + std::to_string(reference_successes) +
                  (configuration.protocol.alone ? "" : " : " + std::to_string(engine_successes)));
      decided = run.decided();
    };
    try {
      runProtocol(
          configuration.protocol, loaded.workerFactory(engine), options.batch.threadCount(),
          references ? &*references : nullptr, take, [&] { return decided || interrupted(); }, finished);
    } catch (const pusht::Error&) {
      if (!decided) {  // else it is of an episode that is not needed
        throw;
      }
    }
    if (!run.whole()) {
      throw pusht::RuntimeFault("interrupted after " + run.progress() +
                                adviceAfterInterruption(options, host, folder ? &*folder : nullptr));
    }
    if (recorder) {
      recorder->finish();
    }
    if (traces) {
      traces->finish();
    }
  } catch (const std::exception& failure) {
    run.abandon(*host.out, failure);
    throw;
  }
  const nlohmann::json metrics = run.finish(*host.out);
  warn(doubtAboutPolicy(metrics, origin, run.summary().endings.reference));
  return {configuration, run.episodes(), metrics, origin, folder ? folder->path() : fs::path()};
}

int compareMain(int argc, char** argv) {
  CompareOptions options;
  CLI::App app("Runs one policy from the same starts in two simulators, and measures the gap.", "compare");
  options.declare(app);
  RequirementOptions required;
  required.declare(app);
  return runCommand(app, argc, argv, [&] {
    const std::vector<Requirement> requirements = required.read();
    for (const Requirement& requirement : requirements) {
      requirement.requireOneRun(options.protocol.until_decided);
      if (options.engine == kNoEngine) {
        requirement.requireReferenceAlone();
      }
    }
    const ComparisonResults results = compare(options);
    if (!requirements.empty()) {
      const Protocol& protocol = results.configuration.protocol;
      const Summary summary = summarize(protocol, results.episodes);
      const std::vector<RequirementResult> answers =
          judgeAll(requirements, [&](const Requirement& requirement) { return judge(requirement, protocol, summary); });
      report("compare", required, answers, std::cout);
      requireAllMet(answers);
    }
  });
}

}  // namespace sim2sim
