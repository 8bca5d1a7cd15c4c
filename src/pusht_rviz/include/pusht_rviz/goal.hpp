// SPDX-License-Identifier: BSD-3-Clause
/// From what people type to a goal of the action `compare`. Nothing is corrected silently: what cannot be is refused,
/// with name, value and rule. Without widgets.
#pragma once

#include <pusht_msgs/CompareGoal.h>
#include <pusht_msgs/DescribeResponse.h>
#include <pusht_msgs/Parameter.h>
#include <pusht_msgs/ParameterDescriptor.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pusht_rviz {

/// Episode i of a run begins from spawn seed kFirstSpawnSeed + seed of the run + i.
inline constexpr std::uint64_t kFirstSpawnSeed = 10'000;

/// What a text says; `value` holds unless it is refused.
template <class Value>
struct Reading {
  Value value{};
  std::string refusal{};  ///< name, value and rule; empty: none
};

Reading<std::uint32_t> readEpisodes(const std::string& text);      ///< from 1 to a million
Reading<std::uint64_t> readRunSeed(const std::string& text);       ///< from 0
Reading<std::uint32_t> readFirstEpisode(const std::string& text);  ///< from 0 to a milliard

/// The episode of a run that begins from a spawn seed.
Reading<std::uint32_t> episodeOfSeed(const std::string& text, std::uint64_t run_seed);

/// Name of the folder for the run after one whose results are in `folder`: "results" gives "results-2", that gives
/// "results-3". Empty stays empty.
std::string nextFolder(const std::string& folder);

/// The rule that `text` breaks as a value of this parameter; empty: none.
std::string refusalOf(const pusht_msgs::ParameterDescriptor& parameter, const std::string& text);

/// "from 0 to 100 [1/s]"; empty: anything goes.
std::string rangeText(const pusht_msgs::ParameterDescriptor& parameter);

/// A parameter of a simulator, as the form has it.
struct Setting {
  pusht_msgs::ParameterDescriptor parameter;
  std::string initial;     ///< its default; of a parameter without a descriptor, what the node said of it first
  std::string base;        ///< what it is unless the goal names it: `initial`, or what a word that the goal names sets
  std::string text;        ///< what it is to be
  bool described = false;  ///< whether the node says what its default is

  /// Whether `text` says something else than `base`: 6 and 6.0 are the same number.
  bool differs() const;
};

/// A simulator, as the form has it.
struct SimulatorDraft {
  std::string kind;  ///< empty: nothing is known of the node
  std::vector<Setting> settings;

  /// `text` is typed for a setting. If it is a word that sets others besides, they follow, unless they differ already.
  void type(std::size_t place, const std::string& text);

  /// What a goal that names the kind says of it, so that what is shown is what runs: the settings that differ, and
  /// those whose default is not known.
  std::vector<pusht_msgs::Parameter> named() const;
};

/// The settings of a simulator of a kind, based on the kind's defaults. `chosen` is written over the texts as far as
/// there are such parameters.
SimulatorDraft draftOf(const std::string& kind, const pusht_msgs::DescribeResponse& described,
                       const std::vector<pusht_msgs::Parameter>& chosen);

/// All that the form says of the next run.
struct RunDraft {
  std::string episodes;
  std::string run_seed;
  std::string out;  ///< folder of the results; empty: the next free one
  std::string first_episode;
  std::string spawn_seed;                           ///< of the first episode
  bool spawned = true;                              ///< false: starts come from a file, and no spawn seed counts
  std::string policy;                               ///< namespace of its services; empty: the evaluator's own
  std::optional<std::uint32_t> requested_episodes;  ///< need not be named, and must not in a smoke run
  std::optional<double> rate;  ///< [control steps/s]; 0: as fast as possible; none: the evaluator's own
  SimulatorDraft reference;
  SimulatorDraft engine;
};

/// Of a field of the form: "episodes", "run_seed", "first_episode", "spawn_seed", "reference.NAME", "engine.NAME".
struct Refusal {
  std::string field;
  std::string rule;
};

/// What is refused; with none, `goal` says what the form says.
struct Draft {
  pusht_msgs::CompareGoal goal;
  std::vector<Refusal> refusals;
};

/// Goal for the next run, with the rules that the form breaks.
Draft goalFrom(const RunDraft& run);

}  // namespace pusht_rviz
