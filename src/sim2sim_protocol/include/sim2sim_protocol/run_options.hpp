// SPDX-License-Identifier: BSD-3-Clause
/// Options of a run, one line of a table for each. All that handles options walks through this table: the evaluator's
/// parameters, goals and their reverse, the description from which the panel builds its form, the command line and its
/// help, plans of sweeps, the description of a run with its hash, the key of the reference cache, and what two runs
/// must agree in to be compared.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "pusht_task/constants.hpp"

namespace sim2sim {

/// Values of the options, which are what a run is asked for besides policy, simulators and a file of initial states.
/// The defaults are those of the course ("Course" in docs/glossary.md).
struct RunOptions {
  std::uint64_t seed = 0;
  int first_episode = 0;
  int episodes = 50;
  int horizon = pusht::kHorizon;                      ///< [control steps]
  double bound_position = pusht::kPositionTolerance;  ///< [m]
  double bound_angle = pusht::kAngleTolerance;        ///< [rad]
  bool floor = true;
  std::vector<int> reanchor{};                 ///< [control steps] between resets; an entry for each state-reset replay
  std::vector<std::string> model_variants{};   ///< as modelVariantsFrom(); a replay for each
  std::vector<std::string> closed_variants{};  ///< likewise; a closed loop for each
  int repeats = 1;                             ///< episodes of each start, with other random numbers
  std::uint64_t noise_seed = 0;
  bool independent_noise = false;
  int execute = 0;                        ///< actions of each answer of the policy; 0: as many as it says
  bool overlapping_starts = false;        ///< bodies of given starts may overlap
  bool target_coverage = false;           ///< measured in a task that is not judged by it, too
  std::optional<double> until_decided{};  ///< [-] share of the reference's success; none: all episodes are run
  std::string task = "full_circle";
};

/// Whether an option decides what the reference does from a given initial state.
enum class Decides {
  kReference,  ///< it does: it is part of the key of the reference cache
  kRest,       ///< it does not: it decides which episodes are run, when the run ends, or what is measured
};

/// Form in which the description of a run (metrics.json, provenance.json) and its hash have an option.
enum class Written {
  kAlways,     ///< under its name; of these, only `episodes` and `horizon` are in the hash
  kIfChanged,  ///< under its name, and in the hash as "|NAME=VALUE", unless it has its default
  kElsewhere,  ///< within another key: "probes" or "bound"
};

/// Range of a number, both ends included. A rule that it cannot say is in Protocol::validate().
struct OptionRange {
  double least = 0.0;
  double greatest = std::numeric_limits<double>::infinity();
};

/// Description of an option that is a member of RunOptions.
template <class Value>
struct RunOption {
  const char* name;     ///< parameter, field or name in a goal, key of the plan; with dashes on the command line
  const char* unit;     ///< empty: none
  const char* meaning;  ///< a phrase for people
  Decides decides;
  Written written;
  bool in_plan;  ///< whether a sweep takes it
  Value RunOptions::*member;
  OptionRange range;  ///< of a number

  const Value& of(const RunOptions& options) const { return options.*member; }
  Value& of(RunOptions& options) const { return options.*member; }

  /// "[m] meaning", for --help.
  std::string help() const { return (*unit == '\0' ? "" : "[" + std::string(unit) + "] ") + meaning; }

  bool isDefault(const RunOptions& options) const {
    static const RunOptions usual;
    return of(options) == of(usual);
  }
};

/// Deduces the type of an option from its member.
template <class Value>
RunOption(const char*, const char*, const char*, Decides, Written, bool, Value RunOptions::*, OptionRange)
    -> RunOption<Value>;

/// Calls function(option) for each option, in the order of --help.
template <class Function>
void forEachOption(const Function& function) {
  const auto each = [&](const char* name, const char* unit, const char* meaning, Decides decides, Written written,
                        bool in_plan, auto member, OptionRange range = {}) {
    function(RunOption{name, unit, meaning, decides, written, in_plan, member, range});
  };
  constexpr double kLastFirstEpisode = 1e9;
  constexpr double kMostEpisodes = 1e6;
  each("task", "", "what is to be done: full_circle, the course's; gym_pusht; or a file NAME.json", Decides::kReference,
       Written::kIfChanged, true, &RunOptions::task);
  each("seed", "", "episode i starts from spawn seed 10000 + seed + i (gym_pusht: 100000 + ...)", Decides::kRest,
       Written::kAlways, true, &RunOptions::seed);
  each("first_episode", "", "index of the first episode", Decides::kRest, Written::kAlways, true,
       &RunOptions::first_episode, {0.0, kLastFirstEpisode});
  each("episodes", "", "number of episodes; without it as many as --starts has, if these are fewer than the default",
       Decides::kRest, Written::kAlways, true, &RunOptions::episodes, {1.0, kMostEpisodes});
  each("horizon", "control steps", "the longest that an episode lasts", Decides::kReference, Written::kAlways, true,
       &RunOptions::horizon, {1.0, pusht::kHorizon});
  each("floor", "",
       "replay the reference from starts moved by 1e-9 m and 1e-6 m: what tiny changes of the start grow to",
       Decides::kRest, Written::kElsewhere, true, &RunOptions::floor);
  each("reanchor", "",
       "K,K,...: also replay with the engine put to the reference's state every K control steps; without K: 1,5,20",
       Decides::kRest, Written::kElsewhere, true, &RunOptions::reanchor);
  each("model_variants", "",
       "VARIANT,...: also replay the reference with other numerics, such as timestep=0.005,cone=elliptic:impratio=10; "
       "without VARIANT: the default ones of its kind",
       Decides::kRest, Written::kElsewhere, true, &RunOptions::model_variants);
  each("closed_variants", "",
       "VARIANT,...: the policy drives these, too: how much success changes over them; without VARIANT: the default "
       "ones "
       "of its kind",
       Decides::kRest, Written::kElsewhere, true, &RunOptions::closed_variants);
  each("bound_position", "m", "beyond it a rollout has diverged from the reference", Decides::kRest,
       Written::kElsewhere, true, &RunOptions::bound_position);
  each("bound_angle", "rad", "beyond it in yaw, a rollout has diverged from the reference", Decides::kRest,
       Written::kElsewhere, true, &RunOptions::bound_angle);
  constexpr double kMostRepeats = 1000;
  each("repeats", "", "episodes of each start, one after the other, with other random numbers of policy and loop",
       Decides::kRest, Written::kIfChanged, true, &RunOptions::repeats, {1.0, kMostRepeats});
  each("noise_seed", "", "seed of the random numbers of policy and loop", Decides::kReference, Written::kIfChanged,
       true, &RunOptions::noise_seed);
  each("independent_noise", "",
       "the engine's closed loop gets other random numbers than the reference's; without it the same", Decides::kRest,
       Written::kIfChanged, true, &RunOptions::independent_noise);
  each("execute", "control steps",
       "actions of each answer of the policy that are executed before it is asked again; 0: as many as it says",
       Decides::kReference, Written::kIfChanged, true, &RunOptions::execute, {0.0, kMostRepeats});
  each("overlapping_starts", "", "bodies of the starts in a file may overlap each other or the walls", Decides::kRest,
       Written::kIfChanged, true, &RunOptions::overlapping_starts);
  each("until_decided", "",
       "stop as soon as it is decided whether the engine keeps this share of the reference's success, above 0 to 1; "
       "--episodes is then the most that it may take",
       Decides::kRest, Written::kIfChanged, false, &RunOptions::until_decided, {0.0, 1.0});
  each("target_coverage", "",
       "measure how much of the target closed loops cover, and success by coverage 0.95 and by 20 mm and 20 degrees; "
       "tasks that coverage judges always have it",
       Decides::kRest, Written::kIfChanged, true, &RunOptions::target_coverage);
}

bool operator==(const RunOptions& a, const RunOptions& b);
inline bool operator!=(const RunOptions& a, const RunOptions& b) { return !(a == b); }

}  // namespace sim2sim
