// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/bag_file.hpp"

#include <console_bridge/console.h>
#include <ros/exception.h>

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

/// rosbag's libraries print some of the errors that they throw; one line is enough.
class QuietLibraries {
 public:
  QuietLibraries() { console_bridge::noOutputHandler(); }
  QuietLibraries(const QuietLibraries&) = delete;
  QuietLibraries& operator=(const QuietLibraries&) = delete;
  ~QuietLibraries() { console_bridge::restorePreviousOutputHandler(); }
};

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

void readBag(const fs::path& path, const std::function<void(const rosbag::Bag&)>& work) {
  const std::string name = "bag " + path.string();
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) {
    throw InvalidInput(name + ": must be a readable file");
  }
  const QuietLibraries quiet;
  try {
    const rosbag::Bag bag(path.string());
    work(bag);
  } catch (Error& error) {
    error.addContext(name);
    throw;
  } catch (const rosbag::BagUnindexedException&) {
    throw InvalidInput(name + ": was not closed; `rosbag reindex " + path.string() + "` recovers it");
  } catch (const ros::Exception& error) {  // of rosbag and of the messages
    if (dynamic_cast<const rosbag::BagIOException*>(&error) != nullptr) {
      sha256OfFile(path, "bag");  // throws if the disk is at fault
    }
    throw InvalidInput(name + ": must be a whole bag: " + error.what() + "; if it was cut short, `rosbag reindex " +
                       path.string() + "` recovers what is left");
  }
}

}  // namespace pusht
