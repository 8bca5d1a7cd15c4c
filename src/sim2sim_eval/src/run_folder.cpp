// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/run_folder.hpp"

#include <array>
#include <system_error>
#include <utility>

#include "pusht_task/files.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetrics = "metrics.json";
constexpr const char* kEpisodes = "episodes.csv";
constexpr const char* kProvenance = "provenance.json";
constexpr const char* kStatus = "status.json";
constexpr std::array<const char*, 4> kResults = {kMetrics, kEpisodes, kProvenance, kStatus};

void refuseUnlessFolder(const fs::path& path) {
  std::error_code ignored;
  if (fs::exists(path, ignored) && !fs::is_directory(path, ignored)) {
    throw pusht::InvalidInput("out " + path.string() + ": must be a folder");
  }
}

void refuseResults(const fs::path& path) {
  for (const char* name : kResults) {
    std::error_code ignored;
    if (fs::exists(path / name, ignored)) {
      throw pusht::InvalidInput("out " + path.string() + ": holds results (" + name +
                                "); name another folder or allow to overwrite");
    }
  }
}

}  // namespace

RunFolder::RunFolder(fs::path path, bool overwrite) : path_(std::move(path)) {
  refuseUnlessFolder(path_);
  if (!overwrite) {
    refuseResults(path_);
  }
}

fs::path RunFolder::nextDefault() {
  std::error_code ignored;
  for (int number = 1;; ++number) {
    fs::path candidate = fs::path("results") / ("compare-" + std::to_string(number));
    if (!fs::exists(candidate, ignored)) {
      return candidate;
    }
  }
}

void RunFolder::begin(const nlohmann::json& provenance) {
  std::error_code error;
  fs::create_directories(path_, error);
  if (error) {
    throw pusht::RuntimeFault("cannot create " + path_.string() + ": " + error.message());
  }
  for (const char* name : kResults) {
    fs::remove(path_ / name, error);
    if (error) {
      throw pusht::RuntimeFault("cannot replace " + (path_ / name).string() + ": " + error.message());
    }
  }
  pusht::writeFile(path_ / kProvenance, jsonText(provenance));
}

void RunFolder::finish(const RunConfiguration& configuration, const std::vector<EpisodeResult>& episodes) {
  pusht::writeFile(path_ / kEpisodes, episodesCsv(episodes));
  pusht::writeFile(path_ / kMetrics, jsonText(metrics(configuration, summarize(episodes))));
  const auto count = static_cast<int>(episodes.size());
  writeStatus({pusht::ExitCode::kOk, "finished", count, count});
}

void RunFolder::abandon(const std::vector<EpisodeResult>& episodes, const RunStatus& status) {
  if (status.exit_code != pusht::ExitCode::kInternalError) {  // after a defect no figure can be trusted
    pusht::writeFile(path_ / kEpisodes, episodesCsv(episodes));
  }
  writeStatus(status);
}

void RunFolder::writeStatus(const RunStatus& status) const {
  pusht::writeFile(path_ / kStatus, jsonText({{"exit_code", static_cast<int>(status.exit_code)},
                                              {"reason", status.reason},
                                              {"episodes_finished", status.episodes_finished},
                                              {"episodes", status.episodes}}));
}

}  // namespace sim2sim
