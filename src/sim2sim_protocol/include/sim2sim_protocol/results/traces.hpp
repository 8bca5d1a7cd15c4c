// SPDX-License-Identifier: BSD-3-Clause
/// traces.npy: the states of the three modes, for pictures and for NumPy.
#pragma once

#include <cstddef>
#include <filesystem>

#include "pusht_task/files.hpp"
#include "sim2sim_protocol/episode.hpp"

namespace sim2sim {

/// Writes a NumPy array of records, one for each state of each mode: episode, mode, step, pusher_x, pusher_y, tee_x,
/// tee_y [m, table frame], tee_yaw [rad], action_x, action_y [m/s, or as the task has them]. The action is the one that
/// follows the state; NaN after the last one. `numpy.load(path)` reads it. The file is complete or absent. Format:
/// NumPy's NEP 1, version 1.0.
class TraceFile {
 public:
  /// Begins the file beside `path`. All functions throw RuntimeFault if it cannot be written.
  explicit TraceFile(const std::filesystem::path& path);

  /// Adds an episode. Episodes come in the order of their indices, which is that of the records.
  void add(const Episode& episode);

  /// Puts the file in its place.
  void finish();

 private:
  pusht::AsideFile file_;
  std::size_t records_ = 0;
};

}  // namespace sim2sim
