// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/run_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
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
constexpr const char* kBag = "compare.bag";
constexpr const char* kKilledBag = "compare.bag.part";  // of a run that was killed
constexpr std::array<const char*, 6> kResults = {kMetrics, kEpisodes, kProvenance, kStatus, kBag, kKilledBag};

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

RunFolder::RunFolder(fs::path path, bool overwrite, std::string command)
    : path_(std::move(path)), overwrite_(overwrite), command_(std::move(command)) {
  if (path_.empty()) {
    return;  // begin() finds one
  }
  refuseUnlessFolder(path_);
  if (!overwrite_) {
    refuseResults(path_);
  }
}

RunFolder::~RunFolder() {
  if (lock_ >= 0) {
    ::close(lock_);
  }
}

void RunFolder::create() {
  std::error_code error;
  if (!path_.empty()) {
    fs::create_directories(path_, error);
  } else {
    fs::create_directories("results", error);
    for (int number = 1; !error; ++number) {
      path_ = fs::path("results") / (command_ + "-" + std::to_string(number));
      if (fs::create_directory(path_, error)) {  // one of several runs at once gets it
        break;
      }
    }
  }
  if (error) {
    throw pusht::RuntimeFault("cannot create " + path_.string() + ": " + error.message());
  }
}

void RunFolder::lock() {
  lock_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) {
    throw pusht::RuntimeFault("cannot open " + path_.string() + ": " + std::strerror(errno));
  }
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    throw pusht::InvalidInput("out " + path_.string() + ": is in use by another run");
  }
}

void RunFolder::begin(const nlohmann::json& provenance) {
  create();
  lock();
  if (!overwrite_) {
    refuseResults(path_);  // another run may have been quicker
  }
  for (const char* name : kResults) {
    std::error_code error;
    fs::remove(path_ / name, error);
    if (error) {
      throw pusht::RuntimeFault("cannot replace " + (path_ / name).string() + ": " + error.message());
    }
  }
  pusht::writeFile(path_ / kProvenance, jsonText(provenance));
}

fs::path RunFolder::bagPath() const { return path_ / kBag; }

void RunFolder::finish(const RunConfiguration& configuration, const std::vector<EpisodeResult>& episodes,
                       int faults_survived) {
  const auto count = static_cast<int>(episodes.size());
  try {
    pusht::writeFile(path_ / kEpisodes, episodesCsv(episodes));
    pusht::writeFile(path_ / kMetrics, jsonText(metrics(configuration, summarize(episodes))));
    writeStatus({pusht::ExitCode::kOk, "finished", count, count, faults_survived});
  } catch (const pusht::RuntimeFault& fault) {
    std::error_code ignored;
    fs::remove(path_ / kMetrics, ignored);  // it would speak for a run that failed
    try {
      writeStatus({fault.exitCode(), fault.what(), count, count, faults_survived});
    } catch (const pusht::RuntimeFault&) {
      // The first fault is the one to report.
    }
    throw;
  }
}

void RunFolder::abandon(const std::vector<EpisodeResult>& episodes, const RunStatus& status) const {
  if (status.exit_code != pusht::ExitCode::kInternalError) {  // after a defect no figure can be trusted
    pusht::writeFile(path_ / kEpisodes, episodesCsv(episodes));
  }
  writeStatus(status);
}

void RunFolder::refuse(const RunStatus& status) {
  create();
  lock();
  refuseResults(path_);  // they stay, even if a run might have replaced them
  writeStatus(status);
}

void RunFolder::writeStatus(const RunStatus& status) const { pusht::writeFile(path_ / kStatus, statusText(status)); }

std::string statusText(const RunStatus& status) {
  return jsonText({{"exit_code", static_cast<int>(status.exit_code)},
                   {"reason", status.reason},
                   {"episodes_finished", status.episodes_finished},
                   {"episodes", status.episodes},
                   {"faults_survived", status.faults_survived}});
}

}  // namespace sim2sim
