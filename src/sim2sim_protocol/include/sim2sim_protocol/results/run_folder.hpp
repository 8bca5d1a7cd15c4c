// SPDX-License-Identifier: BSD-3-Clause
/// Folder with the results of one run.
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

/// Status of a run: how it ended; status.json.
struct RunStatus {
  pusht::ExitCode exit_code = pusht::ExitCode::kOk;
  std::string reason;
  int episodes_finished = 0;
  int episodes = 0;
  int faults_survived = 0;
  bool beside_earlier_results = false;  ///< the other files in the folder are of an earlier run
};

/// Status while a run is under way; it stays if the process is killed.
RunStatus underWay(int episodes);

/// Text of status.json.
std::string statusText(const RunStatus& status);

/// Writer of the folder. Every file is complete or absent. metrics.json is there only for a whole run: finish() writes
/// it.
class RunFolder {
 public:
  /// `path` and `command` are those of OutputFolder. Throws InvalidInput as it does, and if the folder holds results
  /// and `overwrite` is false. With `goes_on` the run may continue: an unfinished run with a journal is accepted, and
  /// begin() takes it up.
  RunFolder(std::filesystem::path path, bool overwrite, std::string command = "compare", bool goes_on = false);

  /// Throws InvalidInput as OutputFolder::refuseInputs().
  void refuseInputs(const std::vector<Input>& inputs) const { folder_.refuseInputs(inputs); }

  /// Whether there is an unfinished run that this one continues.
  bool takesUp() const;

  /// Creates and locks the folder, removes results of an earlier run, and writes provenance and status. A run that may
  /// continue gets a journal() under `identity`, which is all that decides the bytes of its episodes. If there is one
  /// already, results stay, and it throws as Journal does before anything is written. Throws InvalidInput if another
  /// run has locked the folder, RuntimeFault if it cannot be written.
  void begin(const nlohmann::json& provenance, const Protocol& protocol, const nlohmann::json& identity = {});

  /// Journal of a run that may continue; null for other runs.
  Journal* journal() { return journal_ ? &*journal_ : nullptr; }

  /// Writes the results of a whole run. If that fails, the status says so, and RuntimeFault is thrown.
  void finish(const RunConfiguration& configuration, const nlohmann::json& metrics,
              const std::vector<EpisodeResult>& episodes, const DivergenceBands& bands, int faults_survived);

  /// Writes the finished episodes and the status of a run that ended early. After an internal error no figure can be
  /// trusted: it writes the status alone, and removes the journal. Throws RuntimeFault if that fails.
  void abandon(const Protocol& protocol, const std::vector<EpisodeResult>& episodes, const RunStatus& status) const;

  /// Writes a status that says why there was no run. Results that the run would have replaced stay, and the status says
  /// so. An unfinished run that this one would have continued keeps its own status. Throws as begin().
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

/// Calls `load` before a run or sweep begins in `folder`, and returns its result. If a RuntimeFault ends it (an
/// interruption, say), the status in the folder says so. Throws what `load` throws.
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
