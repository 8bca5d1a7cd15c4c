// SPDX-License-Identifier: BSD-3-Clause
/// A run as a picture for rviz: three tables side by side, one with all of them, and how far their tees are apart.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <visualization_msgs/MarkerArray.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim2sim_eval/protocol/protocol.hpp"
#include "sim2sim_eval/results/report.hpp"

namespace sim2sim {

/// Draws what it is told and remembers nothing. Together, scene(), update() and overlay() are the whole picture; each
/// replaces what it drew before, whichever episode or run that was of.
class Picture {
 public:
  struct World {
    std::string frame_prefix;  ///< of its TF frames
    std::string title;         ///< e.g. "MuJoCo, closed loop"
    std::string settings{};    ///< e.g. "block_damp 20.0"; empty: as shipped
  };

  /// The worlds by mode, which is their order on the screen; their prefixes differ.
  explicit Picture(std::array<World, kModeCount> worlds);

  /// Of the simulators of a run.
  static Picture of(const RunConfiguration& run, const std::array<std::string, kModeCount>& frame_prefixes);

  /// Where the worlds stand: static frames from `world` to `<frame_prefix>/table` and from there to the target; the
  /// same for `overlay/table`, and `overlay/card` beside it.
  std::vector<geometry_msgs::TransformStamped> frames() const;

  /// What stays: the worlds, their titles and the axes below them.
  visualization_msgs::MarkerArray scene() const;

  /// What a control step changes: trails, divergence, figures. `summary` is of the finished episodes, none before the
  /// first; `last` is the one that ended the run, none while it goes on. At most 40 kB as a message.
  visualization_msgs::MarkerArray update(const RunConfiguration& run, const Episode& episode,
                                         const std::optional<Summary>& summary, std::optional<int> last) const;

  /// The same of the table on which all worlds are together: the reference solid, the engine's translucent.
  visualization_msgs::MarkerArray overlay(const RunConfiguration& run, const Episode& episode,
                                          const std::optional<Summary>& summary, std::optional<int> last) const;

 private:
  std::array<World, kModeCount> worlds_;
};

}  // namespace sim2sim
