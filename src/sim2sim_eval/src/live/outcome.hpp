// SPDX-License-Identifier: BSD-3-Clause
/// Outcome of a live run: status files, results of goals, hints for the user.
#pragma once

#include <pusht_msgs/CompareResult.h>

#include <exception>
#include <filesystem>
#include <string>

#include "live/request.hpp"
#include "live/world_memory.hpp"
#include "pusht_task/error.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"
#include "sim2sim_serving/node_parameters.hpp"
#include "sim2sim_serving/peer.hpp"

namespace sim2sim {

/// Reason of a failure, clipped to the length of a message (pusht::clipped).
std::string clippedReason(const std::exception& failure);

/// Writes a copy of status.json to `path`; does nothing for an empty path. Throws RuntimeFault if it cannot be written.
void writeStatusFile(const std::string& path, const RunStatus& status);

/// Writes the reason why the node does not start into the status file and the results folder that `parameters` name.
void writeRefusal(pusht::ParameterReader& parameters, const std::exception& failure);

/// Result of a goal whose run has no folder.
pusht_msgs::CompareResult refusal(pusht::ExitCode exit_code, const std::string& reason);

/// Hint how to start a lost node again, to follow the reason; empty if that is not known. A kind that the request
/// leaves open is taken from `memory`.
std::string restartHint(const pusht::NodeMissing& lost, const LiveRequest& request, const WorldMemory& memory);

/// Writes the report of the finished run in `folder` and returns the run's status. If the report cannot be written, the
/// status says so; the results stand.
RunStatus writeReport(const RunStatus& finished, const std::filesystem::path& folder);

}  // namespace sim2sim
