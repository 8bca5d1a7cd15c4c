// SPDX-License-Identifier: BSD-3-Clause
/// Picture of a run for rviz: the answer so far, three views of tables side by side, and one view with all worlds.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <visualization_msgs/MarkerArray.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "pusht_task/task.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/summary.hpp"

namespace sim2sim {

/// State of a run in its picture.
enum class RunState { kWaits, kRuns, kPaused, kFinished, kEnded };

/// Drawing of a run as markers. It has no state: scene(), update() and overlay() are together the whole picture, and
/// each replaces what it drew before, for any episode or run.
///
/// Views show the part of a table where things happen, enlarged. Their content is drawn in the view's own static frame,
/// not placed by TF, and everything that moves comes in one message. So no part of a picture lags behind another.
class Picture {
 public:
  /// World in the picture: its frames, title and colors.
  struct World {
    std::string frame_prefix;               ///< prefix of its TF frames, the frame of its view included
    std::string title;                      ///< e.g. "MuJoCo, the reference"
    std::string subtitle{};                 ///< e.g. "same policy"
    std::vector<std::string> parameters{};  ///< lines of changed parameters: "block_damp 20.0"; none: all defaults
  };

  /// `worlds` by mode, which is their order on the screen. Their prefixes must differ.
  explicit Picture(std::array<World, kModeCount> worlds, const pusht::Task& task = pusht::fullCircle());

  /// Picture of a run, with titles and parameters of its simulators.
  static Picture of(const RunConfiguration& run, const std::array<std::string, kModeCount>& frame_prefixes);

  /// Static frames from `world`: `<frame_prefix>/table`, from there to the target, `<frame_prefix>/window`, and
  /// `overlay/window`.
  std::vector<geometry_msgs::TransformStamped> frames() const;

  /// Constant part: titles and legend.
  visualization_msgs::MarkerArray scene() const;

  /// Part that changes with each control step: worlds, paths, figures. `summary` of the finished episodes, none before
  /// the first; `headline` is the answer in words, empty before there is one. At most 40 kB as a message.
  visualization_msgs::MarkerArray update(const RunConfiguration& run, const Episode& episode,
                                         const std::optional<Summary>& summary, const std::string& headline) const;

  /// Overlay: all worlds in one view, the reference opaque, the engine's translucent.
  visualization_msgs::MarkerArray overlay(const RunConfiguration& run, const Episode& episode,
                                          const std::string& headline) const;

 private:
  std::array<World, kModeCount> worlds_;
  const pusht::Task* task_;
};

/// Line below the headline, in the frame `world`: a band in the color of the state, with `text`.
visualization_msgs::MarkerArray stateMarkers(RunState state, const std::string& text);

}  // namespace sim2sim
