// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/ros/bag_file.hpp"

#include <system_error>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"

namespace pusht {

namespace fs = std::filesystem;

BagFile::BagFile(fs::path path)
    : path_(std::move(path)), aside_(asidePath(path_)), bag_(std::make_unique<rosbag::Bag>()) {
  std::error_code error;
  if (path_.filename().empty() || fs::symlink_status(path_, error).type() != fs::file_type::not_found) {
    throw InvalidInput("bag '" + path_.string() + "': must be the name of a file that does not exist yet");
  }
  try {
    attempt([this] { bag_->open(aside_.string(), rosbag::bagmode::Write); });
  } catch (const RuntimeFault&) {
    discard();
    throw;
  }
  bag_->setCompression(rosbag::compression::LZ4);  // faster than none: what is not compressed is written in small bits
}

BagFile::~BagFile() { discard(); }

void BagFile::discard() {
  try {
    bag_->close();
  } catch (const rosbag::BagException&) {
    // On a full disk a bag cannot be closed, and one that is destroyed while open ends the process.
    (void)bag_.release();  // NOLINT(bugprone-unused-return-value)
  }
  std::error_code ignored;
  fs::remove(aside_, ignored);
}

void BagFile::finish() {
  attempt([this] { bag_->close(); });
  moveIntoPlace(aside_, path_);
}

void BagFile::attempt(const std::function<void()>& action) const {
  try {
    action();
  } catch (const rosbag::BagException& error) {
    throw RuntimeFault("cannot write " + path_.string() + ": " + error.what());
  }
}

}  // namespace pusht
