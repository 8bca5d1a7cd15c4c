// SPDX-License-Identifier: BSD-3-Clause
/// A run as a picture for rviz: the answer so far, three windows side by side, and one window with all worlds in it.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <visualization_msgs/MarkerArray.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/summary.hpp"

namespace sim2sim {

/// State of a run, as its picture shows it.
enum class RunState { kWaits, kRuns, kPaused, kFinished, kEnded };

/// Draws what it is told and remembers nothing. Together, scene(), update() and overlay() are the whole picture; each
/// replaces what it drew before, whichever episode or run that was of.
///
/// The windows show the part of the tables where things happen, enlarged, so they are drawings: nothing in them is
/// placed by TF, and all that moves comes in one message. So nothing in a picture can lag behind something else.
class Picture {
 public:
  struct World {
    std::string frame_prefix;               ///< of its TF frames, and of the frame of its window
    std::string title;                      ///< e.g. "MuJoCo, the reference"
    std::string subtitle{};                 ///< e.g. "same policy"
    std::vector<std::string> parameters{};  ///< lines: "block_damp 20.0"; none: as shipped
  };

  /// The worlds by mode, which is their order on the screen; their prefixes differ.
  explicit Picture(std::array<World, kModeCount> worlds);

  /// Of the simulators of a run.
  static Picture of(const RunConfiguration& run, const std::array<std::string, kModeCount>& frame_prefixes);

  /// Static frames from `world`: `<frame_prefix>/table`, from there to the target, `<frame_prefix>/window`, and
  /// `overlay/window`.
  std::vector<geometry_msgs::TransformStamped> frames() const;

  /// What stays: titles and legend.
  visualization_msgs::MarkerArray scene() const;

  /// What a control step changes: worlds, ways, figures. `summary` is of the finished episodes, none before the first;
  /// `headline` is the answer in words, empty before there is one. At most 40 kB as a message.
  visualization_msgs::MarkerArray update(const RunConfiguration& run, const Episode& episode,
                                         const std::optional<Summary>& summary, const std::string& headline) const;

  /// All worlds in one window: the reference solid, the engine's translucent.
  visualization_msgs::MarkerArray overlay(const RunConfiguration& run, const Episode& episode,
                                          const std::string& headline) const;

 private:
  std::array<World, kModeCount> worlds_;
};

/// The line below the headline, in the frame `world`: a band in the colour of the state, and what is said of it.
visualization_msgs::MarkerArray stateMarkers(RunState state, const std::string& text);

}  // namespace sim2sim
