// SPDX-License-Identifier: BSD-3-Clause
/// Folder of results, which one command at a time writes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sim2sim {

/// Kind of results in a folder: a run (of compare, recompute, the evaluator) or a sweep (of sweep, merge).
enum class Results { kRun, kSweep };

/// Reason in a status while the command runs; it stays if the command is killed.
constexpr const char* kUnderWay = "under way, or killed";

/// File or folder that a command reads.
struct Input {
  std::string what;  ///< "policy"
  std::filesystem::path path;
};

/// Only files of the table of result_files.hpp are ever removed: what else lies in the folder, in `rows` and
/// `reference` too, stays as it is.
class OutputFolder {
 public:
  /// An empty `path` stands for the first free one of results/COMMAND-1, -2, ... below the current folder. Throws
  /// InvalidInput if `path` exists and is no folder. Creates nothing.
  OutputFolder(std::filesystem::path path, std::string command, Results results);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();

  /// Throws InvalidInput if one of `inputs`, with links followed, is where results are written or removed.
  void refuseInputs(const std::vector<Input>& inputs) const;

  /// Throws InvalidInput if the folder holds results of the other kind, which are never replaced, or, unless
  /// `overwrite`, of this kind. A status without a finished episode is not a result.
  void refuseResults(bool overwrite) const;

  /// Throws InvalidInput if the folder holds results of the other kind: of a sweep for a run, of a run for a sweep.
  void refuseOtherResults() const;

  /// Whether there are results besides a status.
  bool holdsResults() const;

  /// Creates the folder and locks it for as long as the object lives. Throws InvalidInput if another command has locked
  /// it, or if there is a link or a file in place of a folder for results; RuntimeFault if it cannot be written.
  void open();

  /// Removes results of this kind except the status, also leftovers, and then their empty folders. Throws RuntimeFault
  /// if that fails.
  void removeResults() const;

  /// Removes unfinished files of a killed process, such as "metrics.json.part". Links and files of the other kind of
  /// results stay.
  void removeLeftovers() const;

  /// Removes the page of results that are about to change.
  void removeReport() const;

  /// Removes the reference cache of a sweep.
  void removeReference() const;

  const std::filesystem::path& path() const { return path_; }

 private:
  [[noreturn]] void refuse(const std::string& why) const;
  std::string nameIn(const std::filesystem::path& path) const;
  void create();
  void lock();

  std::filesystem::path path_;
  std::string command_;
  Results results_;
  int lock_ = -1;
};

}  // namespace sim2sim
