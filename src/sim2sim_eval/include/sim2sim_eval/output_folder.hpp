// SPDX-License-Identifier: BSD-3-Clause
/// A folder that one command at a time writes results into.
#pragma once

#include <filesystem>
#include <string>

namespace sim2sim {

class OutputFolder {
 public:
  /// An empty `path` means the first of results/COMMAND-1, -2, ... below the current folder that is not there yet.
  /// Throws InvalidInput if `path` is there and no folder. Creates nothing.
  OutputFolder(std::filesystem::path path, std::string command);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();

  /// Creates the folder and locks it for as long as the object lives. Throws InvalidInput if another command has locked
  /// it, RuntimeFault if it cannot be written.
  void open();

  /// Throws InvalidInput if the folder holds something that a command has written.
  void refuseResults() const;

  /// Removes all such things. Throws RuntimeFault if that fails.
  void removeResults() const;

  const std::filesystem::path& path() const { return path_; }

 private:
  void create();
  void lock();

  std::filesystem::path path_;
  std::string command_;
  int lock_ = -1;
};

}  // namespace sim2sim
