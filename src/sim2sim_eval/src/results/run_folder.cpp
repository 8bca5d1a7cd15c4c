// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/results/run_folder.hpp"

#include <system_error>
#include <utility>

#include "pusht_task/files.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBag = "compare.bag";
constexpr const char* kTraces = "traces.npy";

}  // namespace

RunFolder::RunFolder(fs::path path, bool overwrite, std::string command)
    : folder_(std::move(path), std::move(command), Results::kRun), overwrite_(overwrite) {
  folder_.refuseResults(overwrite_);
}

void RunFolder::begin(const nlohmann::json& provenance, int episodes) {
  folder_.open();
  folder_.refuseResults(overwrite_);  // another run may have been quicker
  writeStatus(underWay(episodes));    // first, or the status of an earlier run would speak for this one
  folder_.removeResults();
  pusht::writeFile(path() / kProvenanceFile, jsonText(provenance));
}

fs::path RunFolder::bagPath() const { return path() / kBag; }

fs::path RunFolder::tracesPath() const { return path() / kTraces; }

void RunFolder::finish(const RunConfiguration& configuration, const nlohmann::json& metrics,
                       const std::vector<EpisodeResult>& episodes, const DivergenceBands& bands, int faults_survived) {
  const auto count = static_cast<int>(episodes.size());
  try {
    pusht::writeFile(path() / kEpisodesFile, episodesCsv(configuration.protocol, episodes));
    pusht::writeFile(path() / kBandsFile, bands.csv());
    pusht::writeFile(path() / kStatisticsFile, jsonText(statistics(configuration, episodes)));
    pusht::writeFile(path() / kMetricsFile, jsonText(metrics));
    writeStatus({pusht::ExitCode::kOk, "finished", count, count, faults_survived});
  } catch (const pusht::RuntimeFault& fault) {
    std::error_code ignored;
    fs::remove(path() / kMetricsFile, ignored);  // it would speak for a run that failed
    try {
      writeStatus({fault.exitCode(), fault.what(), count, count, faults_survived});
    } catch (const pusht::RuntimeFault&) {
      // The first fault is the one to report.
    }
    throw;
  }
}

void RunFolder::abandon(const Protocol& protocol, const std::vector<EpisodeResult>& episodes,
                        const RunStatus& status) const {
  if (status.exit_code != pusht::ExitCode::kInternalError) {  // after a defect no figure can be trusted
    pusht::writeFile(path() / kEpisodesFile, episodesCsv(protocol, episodes));
  }
  writeStatus(status);
}

void RunFolder::refuse(RunStatus status) {
  folder_.open();
  folder_.refuseResults(overwrite_);
  status.beside_earlier_results = folder_.holdsResults();
  writeStatus(status);
}

void RunFolder::writeStatus(const RunStatus& status) const {
  pusht::writeFile(path() / kStatusFile, statusText(status));
}

RunStatus underWay(int episodes) { return {pusht::ExitCode::kRuntimeFault, kUnderWay, 0, episodes, 0}; }

std::string statusText(const RunStatus& status) {
  nlohmann::json text = {{"format", kStatusFormat},     {"exit_code", static_cast<int>(status.exit_code)},
                         {"reason", status.reason},     {"episodes_finished", status.episodes_finished},
                         {"episodes", status.episodes}, {"faults_survived", status.faults_survived}};
  if (status.beside_earlier_results) {
    text["beside_earlier_results"] = true;
  }
  return jsonText(text);
}

}  // namespace sim2sim
