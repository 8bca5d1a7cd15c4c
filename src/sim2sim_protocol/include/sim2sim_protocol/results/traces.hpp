// SPDX-License-Identifier: BSD-3-Clause
/// traces.npy: what the three worlds did, state by state, for whoever wants to draw it or to compute with it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>

#include "pusht_task/files.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// A NumPy array of records, one for each state of each mode: episode, mode, step, pusher_x, pusher_y, tee_x, tee_y
/// [m], tee_yaw [rad], action_x, action_y [m/s]. The action is the one that follows the state; NaN after the last.
/// `numpy.load(path)` reads it. The file is complete or absent. The format is NumPy's NEP 1, version 1.0.
class TraceFile {
 public:
  /// Throws RuntimeFault if nothing can be written beside `path`, as all functions do.
  TraceFile(const std::filesystem::path& path, const Protocol& protocol);

  /// In any order; they stand in that of their indices.
  void add(const Episode& episode);

  /// Puts the file in its place.
  void finish();

 private:
  void write(const std::string& records);

  pusht::AsideFile file_;
  int next_;                            // episode
  std::map<int, std::string> waiting_;  // records of episodes, for those before them
  std::size_t records_ = 0;             // in the file
};

}  // namespace sim2sim
