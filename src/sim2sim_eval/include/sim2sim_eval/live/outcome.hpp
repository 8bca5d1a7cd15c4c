// SPDX-License-Identifier: BSD-3-Clause
/// How a live run ended, for those who wait for it: in files, in results of goals, in words.
#pragma once

#include <pusht_msgs/CompareResult.h>

#include <exception>
#include <filesystem>
#include <string>

#include "pusht_task/error.hpp"
#include "pusht_task/ros/parameters.hpp"
#include "pusht_task/ros/peer.hpp"
#include "sim2sim_eval/live/request.hpp"
#include "sim2sim_eval/live/world_memory.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"

namespace sim2sim {

/// Reason of a failure, in so few characters that a message takes it.
std::string clippedReason(const std::exception& failure);

/// Writes a copy of status.json; an empty path: none is wanted. Throws RuntimeFault if it cannot be written.
void writeStatusFile(const std::string& path, const RunStatus& status);

/// Leaves the reason why the node does not start where its results would be.
void writeRefusal(pusht::ParameterReader& parameters, const std::exception& failure);

/// The result of a goal whose run has no folder.
pusht_msgs::CompareResult refusal(pusht::ExitCode exit_code, const std::string& reason);

/// How to start the node again that was lost, to be put behind the reason; empty where that is not known. A kind that
/// the request leaves open is what the world was before.
std::string restartHint(const pusht::NodeMissing& lost, const LiveRequest& request, const WorldMemory& memory);

/// Writes the report of the finished run in `folder` and returns the run's status. If the report cannot be written, the
/// status says so; the results stand.
RunStatus writeReport(const RunStatus& finished, const std::filesystem::path& folder);

}  // namespace sim2sim
