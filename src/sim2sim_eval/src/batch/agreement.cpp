// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/agreement.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batch/sweep_description.hpp"
#include "pusht_policy/policy_choice.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"
#include "sim2sim_eval/batch/batch_options.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/loaded_run.hpp"
#include "sim2sim_eval/batch/simulators.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/divergence.hpp"
#include "sim2sim_protocol/model_variants.hpp"
#include "sim2sim_protocol/results/agreement_files.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/runner.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

namespace sim2sim {
namespace {

/// Most episodes whose traces are in memory at once.
constexpr int kEpisodesTogether = 64;

/// Command line of `agreement`.
struct AgreementOptions {
  std::vector<std::string> simulators;  ///< two or more, as for simulatorFromText()
  std::string reference;                ///< simulator whose episodes all replay; empty: the first one
  bool both_ways = false;               ///< all replay the episodes of each simulator instead
  bool variants = true;                 ///< measure each simulator's own model variants, too
  Protocol protocol;
  std::string policy = pusht::kShippedPolicy;
  BatchOptions batch;
};

/// A simulator of the list, with its model variants.
struct Listed {
  SimulatorChoice choice;
  std::vector<SimulatorChoice> variants;
};

/// Replays of an episode in one simulator, in the order of the kinds of replay: traces, and the divergences of a tee
/// that never moves.
struct Replays {
  std::vector<pusht::Trace> traces;
  std::vector<Divergence> null_models;
};

/// Replays in one simulator, by episode.
using Replayed = std::vector<Replays>;

/// Reads a simulator without a loop: its replays take actions, not a policy's answers.
SimulatorChoice choiceFrom(const std::string& text, const AgreementOptions& options) {
  SimulatorChoice choice = simulatorFromText(text);
  requireNoLoop(choice, "an agreement of replays");
  setTask(options.protocol.runTask(), {choice});
  return choice;
}

std::vector<Listed> listedFrom(const AgreementOptions& options) {
  if (options.simulators.size() < 2) {
    throw pusht::InvalidInput("simulators " + pusht::joined(options.simulators) + ": must be two or more");
  }
  std::vector<Listed> listed;
  for (const std::string& text : options.simulators) {
    const SimulatorChoice choice = choiceFrom(text, options);
    if (std::any_of(listed.begin(), listed.end(), [&](const Listed& other) { return other.choice == choice; })) {
      throw pusht::InvalidInput("simulators " + pusht::joined(options.simulators) +
                                ": must be named once each: " + text + " is there twice");
    }
    for (const Listed& other : listed) {
      requireTwoWorlds(other.choice, choice);
    }
    listed.push_back({choice, {}});
    if (options.variants) {
      for (const LoadedVariant& variant : loadDefaultVariants(choice.kind, choice.parameters, choice.task)) {
        listed.back().variants.push_back({choice.kind, variant.model.parameters, choice.loop, {}, choice.task});
      }
    }
  }
  return listed;
}

/// Kinds of replay of a protocol that has no probes but state-reset replays: those, and the open loop.
std::vector<int> replaysOf(const Protocol& protocol) {
  std::vector<int> reset_every = protocol.reanchor;
  reset_every.push_back(0);
  return reset_every;
}

Replays replaysIn(const Episode& episode) {
  Replays replays;
  const std::vector<RolloutResult> results = episode.result().rollouts;
  const auto add = [&](std::size_t rollout) {
    const RolloutResult& result = results[rollout];
    replays.traces.push_back(episode.trace(rollout));
    replays.null_models.push_back({result.at("null_position_divergence"), result.at("null_angle_divergence")});
  };
  for (std::size_t i = kModeCount; i < results.size(); ++i) {
    add(i);
  }
  add(kEngineReplay);
  return replays;
}

/// Samples of all pairs, by kind of replay and divergence.
class Distances {
 public:
  Distances(std::size_t replays, const std::vector<Listed>& listed) : samples_(replays) {
    for (auto& of_replay : samples_) {
      for (AgreementSamples& samples : of_replay) {
        samples.pairs.assign(listed.size(), std::vector<DistanceSamples>(listed.size()));
        for (const Listed& simulator : listed) {
          samples.variants.emplace_back(simulator.variants.size());
        }
      }
    }
  }

  /// Adds the distance of two listed simulators, in one direction.
  void addPair(std::size_t from, std::size_t to, const Replayed& first, const Replayed& second) {
    add(
        [&](AgreementSamples & samples) -> auto& { return samples.pairs[from][to]; }, first, second);
  }

  void addVariant(std::size_t simulator, std::size_t variant, const Replayed& first, const Replayed& second) {
    add(
        [&](AgreementSamples & samples) -> auto& { return samples.variants[simulator][variant]; }, first, second);
  }

  std::vector<AgreementReplay> figures(const std::vector<int>& reset_every) const {
    std::vector<AgreementReplay> replays;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      requireNotInterrupted();
      AgreementReplay& replay = replays.emplace_back(AgreementReplay{reset_every[i], {}});
      for (std::size_t k = 0; k < kAgreementDivergences; ++k) {
        const Quantity& quantity = kQuantities[quantityIndex(kDivergencePairs[k].divergence)];
        replay.figures[k] = figuresOf(samples_[i][k], quantity);
      }
    }
    return replays;
  }

 private:
  template <class Choose>
  void add(const Choose& choose, const Replayed& first, const Replayed& second) {
    for (std::size_t episode = 0; episode < first.size(); ++episode) {
      for (std::size_t i = 0; i < samples_.size(); ++i) {
        const Divergence mean = meanDivergence(first[episode].traces[i], second[episode].traces[i]);
        const Divergence& rest = second[episode].null_models[i];
        DistanceSamples& position = choose(samples_[i][0]);
        position.divergence.push_back(mean.position);
        position.null_model.push_back(rest.position);
        DistanceSamples& angle = choose(samples_[i][1]);
        angle.divergence.push_back(mean.angle);
        angle.null_model.push_back(rest.angle);
      }
    }
  }

  std::vector<std::array<AgreementSamples, kAgreementDivergences>> samples_;
};

/// Replays the episodes of one reference in other simulators.
class Replayer {
 public:
  Replayer(const AgreementOptions& options, const LoadedRun& loaded, const SimulatorChoice& reference, ProgressBar& bar)
      : options_(options),
        loaded_(loaded),
        reference_(reference),
        references_(options.batch.references(loaded, options.protocol)),
        bar_(bar) {}

  /// Replays the episodes of `share` in `simulators`. The reference itself, if it is among them, has its own traces.
  std::vector<Replayed> replay(const Protocol& share, const std::vector<SimulatorChoice>& simulators) const {
    std::vector<Replayed> replayed(simulators.size());
    Replayed of_reference;
    for (std::size_t i = 0; i < simulators.size(); ++i) {
      if (!(simulators[i] == reference_)) {
        replayed[i] = replay(share, simulators[i], of_reference);
      }
    }
    std::replace_if(replayed.begin(), replayed.end(), std::mem_fn(&Replayed::empty), of_reference);
    return replayed;
  }

 private:
  /// Replays in one simulator; `of_reference` gets the traces of the reference.
  Replayed replay(const Protocol& share, const SimulatorChoice& simulator, Replayed& of_reference) const {
    Replayed replayed;
    of_reference.clear();
    const auto take = [&](const Episode& episode) {
      replayed.push_back(replaysIn(episode));
      of_reference.push_back(replayed.back());
      std::fill(of_reference.back().traces.begin(), of_reference.back().traces.end(),
                episode.rollout(kReferenceClosed).trace());
      bar_.advance(textOf(simulator));
    };
    const LoadedSimulator engine(simulator);
    try {
      runProtocol(share, loaded_.workerFactory(engine), options_.batch.threadCount(),
                  references_ ? &*references_ : nullptr, take, interrupted);
    } catch (pusht::Error& error) {
      error.addContext(textOf(simulator) + " along " + textOf(reference_));
      throw;
    }
    requireNotInterrupted("in " + textOf(simulator) + " along " + textOf(reference_));
    return replayed;
  }

  const AgreementOptions& options_;
  const LoadedRun& loaded_;
  const SimulatorChoice& reference_;
  std::optional<ReferenceCache> references_;
  ProgressBar& bar_;
};

/// A reference, and the simulators of the list that are measured along its episodes: each against all others and
/// against its variants.
struct Along {
  SimulatorChoice reference;
  std::vector<std::size_t> measured;  ///< places in the list, ascending
};

/// Measures along the episodes of one reference after the other.
class PairsOfList {
 public:
  /// `options` have their number of episodes and their initial states.
  PairsOfList(const AgreementOptions& options, const std::vector<Listed>& listed, const std::vector<Along>& alongs)
      : options_(options),
        listed_(listed),
        alongs_(alongs),
        distances_(replaysOf(options.protocol).size(), listed),
        bar_("episodes", options.protocol.episodes * runs()) {}

  Agreement agreement() {
    Agreement result;
    for (const Along& along : alongs_) {
      result.run = measure(along);
    }
    if (options_.both_ways) {
      result.run.erase("reference_simulator");
    } else {
      result.reference = LoadedSimulator(alongs_.front().reference).record();
    }
    for (const Listed& simulator : listed_) {
      AgreementSimulator& named = result.simulators.emplace_back(
          AgreementSimulator{textOf(simulator.choice), LoadedSimulator(simulator.choice).record(), {}});
      std::transform(simulator.variants.begin(), simulator.variants.end(), std::back_inserter(named.variants), textOf);
    }
    result.replays = distances_.figures(replaysOf(options_.protocol));
    return result;
  }

 private:
  /// Simulators that replay: those of the list, then the variants in their order.
  std::vector<SimulatorChoice> simulatorsOf(const Along& along) const {
    std::vector<SimulatorChoice> simulators;
    for (const Listed& simulator : listed_) {
      simulators.push_back(simulator.choice);
    }
    for (const std::size_t i : along.measured) {
      simulators.insert(simulators.end(), listed_[i].variants.begin(), listed_[i].variants.end());
    }
    return simulators;
  }

  /// Number of runs of all episodes: one for each simulator along each other.
  std::int64_t runs() const {
    std::int64_t runs = 0;
    for (const Along& along : alongs_) {
      const std::vector<SimulatorChoice> all = simulatorsOf(along);
      runs += std::count_if(all.begin(), all.end(), [&](const auto& one) { return !(one == along.reference); });
    }
    return runs;
  }

  /// Adds the distances along the episodes of one reference. Returns the description of the episodes.
  nlohmann::json measure(const Along& along) {
    const std::vector<SimulatorChoice> simulators = simulatorsOf(along);
    const pusht::PolicyChoice policy{options_.policy, true, options_.protocol.seed, false, options_.protocol.runTask()};
    const LoadedRun loaded(policy, along.reference, simulators, options_.protocol);
    const Replayer replayer(options_, loaded, along.reference, bar_);
    Protocol share = options_.protocol;
    for (int done = 0; done < options_.protocol.episodes; done += share.episodes) {
      share.first_episode = options_.protocol.first_episode + done;
      share.episodes = std::min(kEpisodesTogether, options_.protocol.episodes - done);
      add(replayer.replay(share, simulators), along);
    }
    return describeWithoutEngine(options_.protocol, loaded);
  }

  void add(const std::vector<Replayed>& replayed, const Along& along) {
    std::size_t next_variant = listed_.size();
    for (const std::size_t i : along.measured) {
      for (std::size_t j = 0; j < listed_.size(); ++j) {
        if (j != i) {
          distances_.addPair(i, j, replayed[i], replayed[j]);
        }
      }
      for (std::size_t variant = 0; variant < listed_[i].variants.size(); ++variant) {
        distances_.addVariant(i, variant, replayed[i], replayed[next_variant++]);
      }
    }
  }

  const AgreementOptions& options_;
  const std::vector<Listed>& listed_;
  const std::vector<Along>& alongs_;
  Distances distances_;
  ProgressBar bar_;
};

/// References, in the order of their runs.
std::vector<Along> alongsOf(const AgreementOptions& options, const std::vector<Listed>& listed) {
  std::vector<std::size_t> all(listed.size());
  std::iota(all.begin(), all.end(), 0);
  if (!options.both_ways) {
    return {{options.reference.empty() ? listed.front().choice : choiceFrom(options.reference, options), all}};
  }
  std::vector<Along> alongs;
  std::transform(all.begin(), all.end(), std::back_inserter(alongs), [&](std::size_t i) {
    return Along{listed[i].choice, {i}};
  });
  return alongs;
}

}  // namespace

/// Replays the actions of a policy in all simulators, prints the distances of all pairs, and writes them.
int agreementMain(int argc, char** argv) {
  AgreementOptions options;
  Protocol& protocol = options.protocol;
  protocol.floor = false;
  protocol.reanchor = {1, 5, 20};
  std::string starts;
  std::filesystem::path out;
  CLI::App app(
      "Says how far all pairs of simulators part when they replay the same actions from the same states, and which one "
      "is in the middle.",
      "agreement");
  app.add_option("simulators", options.simulators,
                 "two or more, each KIND or KIND:NAME=VALUE:NAME=VALUE; kinds are " +
                     pusht::joined(pusht::SimulatorKinds::installed().names()))
      ->required()
      ->check(notEmpty());
  app.add_option("--reference", options.reference, "simulator whose episodes all replay (default: the first one)")
      ->check(notEmpty());
  app.add_flag("--both-ways", options.both_ways, "all replay the episodes of each simulator instead")
      ->excludes("--reference");
  app.add_flag("!--no-variants", options.variants,
               "leave out the distance of each simulator from its own model variants");
  app.add_option("--policy", options.policy, "policy whose actions are replayed, as for `compare`")
      ->capture_default_str();
  declare(app, protocol,
          {"task", "seed", "first_episode", "episodes", "horizon", "reanchor", "noise_seed", "execute",
           "overlapping_starts"});
  app.add_option("--starts", starts, "CSV file with the start of each episode, instead of spawn seeds")
      ->check(notEmpty());
  app.add_option("--out", out, "write the agreement into a new JSON file")->check(notEmpty());
  options.batch.declare(app);
  return runCommand(app, argc, argv, [&] {
    pusht::requireNewFile("out", out);
    if (app.count("--episodes") == 0) {
      protocol.episodes = defaultEpisodes(protocol, starts);
    }
    protocol.carryTask();
    protocol.validate();
    protocol.initial_states = givenInitialStates(starts, protocol.firstStart(), protocol.starts(),
                                                 protocol.overlapping_starts, protocol.runTask());
    const std::vector<Listed> listed = listedFrom(options);
    const std::vector<Along> alongs = alongsOf(options, listed);
    const Agreement result = PairsOfList(options, listed, alongs).agreement();
    requireNotInterrupted();
    std::cout << table(result);
    if (!out.empty()) {
      pusht::writeNewFile("out", out, jsonText(toJson(result)));
    }
  });
}

}  // namespace sim2sim
