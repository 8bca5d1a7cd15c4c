// SPDX-License-Identifier: BSD-3-Clause
/// The folder that holds the results of one run.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/bands.hpp"
#include "sim2sim_protocol/results/journal.hpp"
#include "sim2sim_protocol/results/output_folder.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {

/// How a run ended; status.json.
struct RunStatus {
  pusht::ExitCode exit_code = pusht::ExitCode::kOk;
  std::string reason;
  int episodes_finished = 0;
  int episodes = 0;
  int faults_survived = 0;
  bool beside_earlier_results = false;  ///< the other files in the folder are not of this run
};

/// Status while a run is under way; it stays if the process is killed.
RunStatus underWay(int episodes);

/// The text of status.json.
std::string statusText(const RunStatus& status);

/// Every file in it is complete or absent. metrics.json speaks for a whole run: it is only written by finish().
class RunFolder {
 public:
  /// Opens the OutputFolder; throws InvalidInput, too, if `path` holds results that must stay. Those of a run that is
  /// not finished need not, if `goes_on`: begin() takes them up.
  RunFolder(std::filesystem::path path, bool overwrite, std::string command = "compare", bool goes_on = false);

  /// As OutputFolder.
  void refuseInputs(const std::vector<Input>& inputs) const { folder_.refuseInputs(inputs); }

  /// Whether there is an unfinished run that this one takes up.
  bool takesUp() const;

  /// Creates the folder, without results of an earlier run, and writes what the run depends on and that it is under
  /// way. From here on the folder is locked. Throws InvalidInput if another run has locked it, RuntimeFault if it
  /// cannot be written. A run that may go on keeps a journal() under `identity`, which is all that decides the bytes of
  /// its episodes. If there is one already, results stay, and it throws as Journal does, before it writes anything.
  void begin(const nlohmann::json& provenance, const Protocol& protocol, const nlohmann::json& identity = {});

  /// Null unless the run may go on after an interruption.
  Journal* journal() { return journal_ ? &*journal_ : nullptr; }

  /// The results of a whole run. If they cannot be written, the status says so, and RuntimeFault is thrown.
  void finish(const RunConfiguration& configuration, const nlohmann::json& metrics,
              const std::vector<EpisodeResult>& episodes, const DivergenceBands& bands, int faults_survived);

  /// The finished episodes of a run that ended early.
  void abandon(const Protocol& protocol, const std::vector<EpisodeResult>& episodes, const RunStatus& status) const;

  /// Only says why there was no run. Results that the run would have replaced stay; the status says so. An unfinished
  /// run that this one would have taken up keeps its own status. Throws as begin() does.
  void refuse(RunStatus status);

  const std::filesystem::path& path() const { return folder_.path(); }

  /// Path of the run's bag, which the recorder writes.
  std::filesystem::path bagPath() const;

  /// Path of the run's traces, which a TraceFile writes.
  std::filesystem::path tracesPath() const;

 private:
  void writeStatus(const RunStatus& status) const;

  void refuseResults() const;

  OutputFolder folder_;
  bool overwrite_;
  bool goes_on_;
  std::optional<Journal> journal_;
};

/// What `load` gives, before a run or sweep begins in `folder`. If a fault ends it (an interruption, say), the folder
/// says so.
template <class Folder, class Load>
auto loadFor(Folder& folder, const Load& load) {
  try {
    return load();
  } catch (const pusht::Error& fault) {
    if (fault.exitCode() == pusht::ExitCode::kRuntimeFault) {
      try {
        folder.refuse({fault.exitCode(), fault.what()});
      } catch (const pusht::Error&) {
        // The first fault is the one to report.
      }
    }
    throw;
  }
}

}  // namespace sim2sim
