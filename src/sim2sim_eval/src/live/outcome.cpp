// SPDX-License-Identifier: BSD-3-Clause
#include "live/outcome.hpp"

#include <ros/console.h>

#include <boost/process/search_path.hpp>
#include <boost/process/system.hpp>
#include <functional>
#include <system_error>
#include <vector>

#include "live/evaluator_parameters.hpp"
#include "pusht_task/clipped.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/reason.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

namespace sim2sim {

std::string clippedReason(const std::exception& failure) { return pusht::clipped(pusht::reasonOf(failure)); }

void writeStatusFile(const std::string& path, const RunStatus& status) {
  if (!path.empty()) {
    pusht::writeFile(path, statusText(status));
  }
}

void writeRefusal(pusht::ParameterReader& parameters, const std::exception& failure) {
  const RunStatus status = {pusht::exitCodeOf(failure), clippedReason(failure), 0, 0, 0};
  const auto attempt = [](const std::function<void()>& tell) {
    try {
      tell();
    } catch (const pusht::Error&) {
      // The caller reports the failure itself.
    }
  };
  attempt([&] { writeStatusFile(EvaluatorParameters::statusFileOf(parameters), status); });
  attempt(
      [&] { RunFolder(EvaluatorParameters::outOf(parameters), parameters.flag("overwrite", false)).refuse(status); });
}

pusht_msgs::CompareResult refusal(pusht::ExitCode exit_code, const std::string& reason) {
  pusht_msgs::CompareResult result;
  result.exit_code = static_cast<int>(exit_code);
  result.reason = reason;
  return result;
}

std::string restartHint(const pusht::NodeMissing& lost, const LiveRequest& request, const WorldMemory& memory) {
  const std::string name = lost.services.empty() ? "" : lost.services.substr(1);
  if (name.empty() || name.find('/') != std::string::npos) {
    return "";
  }
  const std::string restart = "; if it is down, start it again and send the goal again: roslaunch ";
  if (lost.services == request.services.policy) {
    return restart + "pusht_policy policy.launch name:=" + name;
  }
  const auto& worlds = request.services.worlds;
  const bool reference = lost.services == worlds[kReferenceClosed];
  std::string kind = (reference ? request.simulators.reference : request.simulators.engine).kind;
  for (const std::string& world : {lost.services, reference ? lost.services : worlds[kEngineClosed]}) {
    kind = kind.empty() ? memory.kindOf(world) : kind;
  }
  if (!kind.empty() && !pusht::SimulatorKinds::installed().has(kind)) {
    return "; if it is down, start your node for " + lost.services + " again and send the goal again";
  }
  return restart + "sim2sim_eval simulator.launch name:=" + name + " kind:=" + (kind.empty() ? "KIND" : kind);
}

RunStatus writeReport(const RunStatus& finished, const std::filesystem::path& folder) {
  namespace process = boost::process;
  RunStatus status = finished;
  try {
    const int code =
        process::system(process::search_path("rosrun"), "sim2sim_eval", "report", folder.string(), "--overwrite");
    if (code == 0) {
      return status;
    }
    status.reason = "the run finished, but its report was not written: report ended with exit code " +
                    std::to_string(code) + "; its own line says why";
  } catch (const process::process_error& error) {
    status.reason = "the run finished, but its report was not written: rosrun: " + error.code().message();
  }
  status.exit_code = pusht::ExitCode::kRuntimeFault;
  ROS_ERROR_STREAM(status.reason);
  return status;
}

}  // namespace sim2sim
