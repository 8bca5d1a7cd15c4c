// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/run_folder.hpp"

#include <system_error>
#include <utility>

#include "pusht_task/files.hpp"
#include "sim2sim_protocol/results/episodes_csv.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/statistics.hpp"

namespace sim2sim {

namespace fs = std::filesystem;

RunFolder::RunFolder(fs::path path, bool overwrite, std::string command, bool goes_on)
    : folder_(std::move(path), std::move(command), Results::kRun), overwrite_(overwrite), goes_on_(goes_on) {
  refuseResults();
}

bool RunFolder::takesUp() const {
  std::error_code ignored;
  return goes_on_ && !overwrite_ && !path().empty() && fs::exists(path() / kJournalFile, ignored) &&
         !fs::exists(path() / kMetricsFile, ignored);
}

void RunFolder::refuseResults() const {
  if (takesUp()) {
    folder_.refuseOtherResults();
  } else {
    folder_.refuseResults(overwrite_);
  }
}

void RunFolder::begin(const nlohmann::json& provenance, const Protocol& protocol, const nlohmann::json& identity) {
  folder_.open();
  refuseResults();  // another run may have been quicker
  const bool takes_up = takesUp();
  const auto open_journal = [&] { journal_.emplace(path() / kJournalFile, protocol, identity); };
  if (takes_up) {
    open_journal();  // first: what it refuses stays as it is
  }
  RunStatus status = underWay(protocol.episodes);
  status.episodes_finished = takes_up ? static_cast<int>(journal_->kept().size()) : 0;
  writeStatus(status);  // before anything is removed, or the status of an earlier run would speak for this one
  try {
    if (takes_up) {
      folder_.removeLeftovers();
      folder_.removeReport();
    } else {
      folder_.removeResults();
    }
    if (goes_on_ && !takes_up) {
      open_journal();
    }
    pusht::writeFile(path() / kProvenanceFile, jsonText(provenance));
  } catch (const pusht::RuntimeFault& fault) {
    status.reason = fault.what();
    writeStatus(status);
    throw;
  }
}

fs::path RunFolder::bagPath() const { return path() / kBagFile; }

fs::path RunFolder::tracesPath() const { return path() / kTracesFile; }

void RunFolder::finish(const RunConfiguration& configuration, const nlohmann::json& metrics,
                       const std::vector<EpisodeResult>& episodes, const DivergenceBands& bands, int faults_survived) {
  const auto count = static_cast<int>(episodes.size());
  try {
    pusht::writeFile(path() / kEpisodesFile, episodesCsv(configuration.protocol, episodes));
    pusht::writeFile(path() / kBandsFile, bands.csv());
    pusht::writeFile(path() / kStatisticsFile, jsonText(statistics(configuration, episodes)));
    pusht::writeFile(path() / kMetricsFile, jsonText(metrics));
    writeStatus({pusht::ExitCode::kOk, "finished", count, count, faults_survived});
    if (journal_) {
      journal_->remove();
    }
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
  } else {
    std::error_code ignored;
    fs::remove(path() / kJournalFile, ignored);
  }
  writeStatus(status);
}

void RunFolder::refuse(RunStatus status) {
  folder_.open();
  refuseResults();
  if (takesUp()) {
    return;  // the status of the unfinished run stays: it tells how many episodes there are
  }
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
