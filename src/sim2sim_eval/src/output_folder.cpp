// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/output_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "pusht_task/error.hpp"

namespace sim2sim {

namespace fs = std::filesystem;

namespace {

/// Of every command, so that no two of them mix in a folder.
constexpr std::array<const char*, 10> kResults = {"metrics.json",     "episodes.csv", "provenance.json",
                                                  "status.json",      "compare.bag",
                                                  "compare.bag.part",  // of a run that was killed
                                                  "sweep.json",       "sweep.csv",    "rows",
                                                  "reference"};

}  // namespace

OutputFolder::OutputFolder(fs::path path, std::string command) : path_(std::move(path)), command_(std::move(command)) {
  std::error_code ignored;
  if (fs::exists(path_, ignored) && !fs::is_directory(path_, ignored)) {
    throw pusht::InvalidInput("out " + path_.string() + ": must be a folder");
  }
}

OutputFolder::~OutputFolder() {
  if (lock_ >= 0) {
    ::close(lock_);
  }
}

void OutputFolder::open() {
  create();
  lock();
}

void OutputFolder::refuseResults() const {
  for (const char* name : kResults) {
    std::error_code ignored;
    if (!path_.empty() && fs::exists(path_ / name, ignored)) {
      throw pusht::InvalidInput("out " + path_.string() + ": holds results (" + name +
                                "); name another folder or allow to overwrite");
    }
  }
}

void OutputFolder::removeResults() const {
  for (const char* name : kResults) {
    std::error_code error;
    fs::remove_all(path_ / name, error);
    if (error) {
      throw pusht::RuntimeFault("cannot replace " + (path_ / name).string() + ": " + error.message());
    }
  }
}

void OutputFolder::create() {
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

void OutputFolder::lock() {
  lock_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) {
    throw pusht::RuntimeFault("cannot open " + path_.string() + ": " + std::strerror(errno));
  }
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    throw pusht::InvalidInput("out " + path_.string() + ": is in use by another run");
  }
}

}  // namespace sim2sim
