// SPDX-License-Identifier: BSD-3-Clause
/// A folder that one command at a time writes results into.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace sim2sim {

/// What a results folder holds: a run (of compare, recompute, the evaluator) or a sweep (of sweep, merge).
enum class Results { kRun, kSweep };

// Files of a run, and of a sweep's rows.
constexpr const char* kMetricsFile = "metrics.json";
constexpr const char* kStatisticsFile = "statistics.json";
constexpr const char* kBandsFile = "divergence.csv";
constexpr const char* kEpisodesFile = "episodes.csv";
constexpr const char* kProvenanceFile = "provenance.json";
constexpr const char* kStatusFile = "status.json";

constexpr const char* kJournalFile = "episodes.journal";  ///< of a run, or of a row, that is not finished

constexpr const char* kSweepFile = "sweep.json";

// Of what is said of a sweep.
constexpr const char* kAttributionFile = "attribution.json";
constexpr const char* kAttributionTable = "attribution.csv";

/// The folder of a row of a sweep: rows/007.
std::filesystem::path rowFolder(const std::filesystem::path& sweep, std::size_t row);

constexpr int kStatusFormat = 1;  ///< of status.json

/// The reason in a status before the end, and for ever of a command that was killed.
constexpr const char* kUnderWay = "under way, or killed";

/// A file or folder that a command reads.
struct Input {
  std::string what;  ///< "policy"
  std::filesystem::path path;
};

/// The names that the commands write under are known here alone. Only they are ever removed: what else lies in the
/// folder, in `rows` and `reference` too, stays as it is.
class OutputFolder {
 public:
  /// An empty `path` means the first of results/COMMAND-1, -2, ... below the current folder that is not there yet.
  /// Throws InvalidInput if `path` is there and no folder. Creates nothing.
  OutputFolder(std::filesystem::path path, std::string command, Results results);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();

  /// Throws InvalidInput if one of `inputs` lies, links followed, where results are written to or removed.
  void refuseInputs(const std::vector<Input>& inputs) const;

  /// Throws InvalidInput if the folder holds results of the other kind, which are never replaced, or, unless
  /// `overwrite`, of this kind. A status that tells of no finished episode is not a result.
  void refuseResults(bool overwrite) const;

  /// Throws InvalidInput if the folder holds results of the other kind: of a sweep for a run, of a run for a sweep.
  void refuseOtherResults() const;

  /// Whether there are results besides a status.
  bool holdsResults() const;

  /// Creates the folder and locks it for as long as the object lives. Throws InvalidInput if another command has locked
  /// it or a link or a file is in it where a folder for results belongs, RuntimeFault if it cannot be written.
  void open();

  /// Removes the results of this kind besides the status, leftovers too, and folders of theirs that are empty then.
  /// Throws RuntimeFault if that fails.
  void removeResults() const;

  /// Removes what a killed process has left of files that it was writing: "metrics.json.part". A link is not ours, nor
  /// what belongs to another kind of results.
  void removeLeftovers() const;

  /// Removes the report of results that are about to change.
  void removeReport() const;

  /// Removes what a sweep keeps of the reference.
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
