// SPDX-License-Identifier: BSD-3-Clause
/// A run as a picture for rviz: three tables side by side, and how far their tees are apart.
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

/// Draws what it is told and remembers nothing. Together, scene() and update() are the whole picture; each replaces
/// what it drew before, whichever episode or run that was of.
class Picture {
 public:
  struct World {
    std::string frame_prefix;  ///< of its TF frames
    std::string title;         ///< e.g. "MuJoCo, closed loop"
  };

  /// The worlds by mode, which is their order on the screen; their prefixes differ.
  explicit Picture(std::array<World, kModeCount> worlds);

  /// Where the worlds stand: static frames from `world` to `<frame_prefix>/table` and from there to the target.
  std::vector<geometry_msgs::TransformStamped> frames() const;

  /// What stays: the worlds, their titles and the axes below them.
  visualization_msgs::MarkerArray scene() const;

  /// What a control step changes: trails, divergence, figures. `summary` is of the finished episodes, none before the
  /// first; of all that there are: the run has finished. At most 30 kB as a message.
  visualization_msgs::MarkerArray update(const RunConfiguration& run, const Episode& episode,
                                         const std::optional<Summary>& summary) const;

 private:
  std::array<World, kModeCount> worlds_;
};

}  // namespace sim2sim
