// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/bag_file.hpp"

#include <system_error>
#include <utility>

#include "pusht_task/error.hpp"

namespace pusht {

namespace fs = std::filesystem;

namespace {

/// Throws InvalidInput if there is something at `path` already.
const fs::path& requireFree(const fs::path& path) {
  std::error_code error;
  if (path.filename().empty() || fs::symlink_status(path, error).type() != fs::file_type::not_found) {
    throw InvalidInput("bag '" + path.string() + "': must be the name of a file that does not exist yet");
  }
  return path;
}

}  // namespace

BagFile::BagFile(fs::path path)
    : path_(std::move(path)), file_(requireFree(path_)), bag_(std::make_unique<rosbag::Bag>()) {
  try {
    attempt([this] { bag_->open(file_.aside().string(), rosbag::bagmode::Write); });
  } catch (const RuntimeFault&) {
    close();
    throw;
  }
  bag_->setCompression(rosbag::compression::LZ4);  // faster than none: what is not compressed is written in small bits
}

BagFile::~BagFile() { close(); }

void BagFile::close() {
  try {
    bag_->close();
  } catch (const rosbag::BagException&) {
    // On a full disk a bag cannot be closed, and one that is destroyed while open ends the process.
    (void)bag_.release();  // NOLINT(bugprone-unused-return-value)
  }
}

void BagFile::finish() {
  attempt([this] { bag_->close(); });
  file_.moveIntoNewPlace("bag");
}

void BagFile::attempt(const std::function<void()>& action) const {
  try {
    action();
  } catch (const rosbag::BagException& error) {
    throw RuntimeFault("cannot write " + path_.string() + ": " + error.what());
  }
}

}  // namespace pusht
