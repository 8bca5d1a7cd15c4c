// SPDX-License-Identifier: BSD-3-Clause
/// Folder of a sweep, or of a shard of one: reading it and writing it.
#pragma once

#include <cstddef>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/reason.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/results/journal.hpp"
#include "sim2sim_protocol/results/output_folder.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"
#include "sim2sim_protocol/results/run_results.hpp"
#include "sim2sim_protocol/results/summary.hpp"

namespace sim2sim {

/// Files and folders that are read of a shard.
std::vector<Input> inputsOf(const std::filesystem::path& shard);

/// First difference of a sweep on disk, or of the build that ran it, from the one that is wanted, with both values:
/// "/seed is 1, must be 0". Empty if there is none.
std::string differenceOf(const SweepResults& found, const nlohmann::json& description,
                         const nlohmann::json& provenance);

/// Finished row: its episodes, their summary and its metrics.json.
struct SweepRow {
  SweepRow(const RunConfiguration& configuration, std::vector<EpisodeResult> results);

  std::vector<EpisodeResult> episodes;
  Summary summary;
  nlohmann::json metrics;
};

/// Reads row `index` of the sweep in `folder`; none if it is not finished. Throws BadDependency, naming the file, if
/// its episodes were changed on disk, or are not those of `configuration`.
std::optional<SweepRow> readRow(const std::filesystem::path& folder, std::size_t index,
                                const RunConfiguration& configuration);

/// Writer of a sweep, over an OutputFolder.
class SweepFolder {
 public:
  /// Throws as the constructor of OutputFolder.
  SweepFolder(std::filesystem::path path, bool overwrite, std::string command);

  /// Throws as OutputFolder::refuseInputs().
  void refuseInputs(const std::vector<Input>& inputs) const { folder_.refuseInputs(inputs); }

  /// Begins the sweep of this `description`, or continues it if the folder holds it. Throws InvalidInput if the folder
  /// holds other results that must stay; as OutputFolder::open() otherwise.
  void begin(const nlohmann::json& description, const nlohmann::json& provenance);

  /// Journal of the row under way; keep() and resume() remove it. Throws as the constructor of Journal.
  Journal journal(std::size_t index, const RunConfiguration& configuration) const;

  /// Writes a finished row. Rows come in order. Throws RuntimeFault if it cannot be written.
  void keep(std::size_t index, const RunConfiguration& configuration, const SweepRow& row);

  /// Counts a row that is on disk as finished. Rows come in order.
  void resume(std::size_t index, nlohmann::json metrics);

  /// Writes only why the sweep does not begin, into status.json. A sweep in the folder keeps its own status. Throws as
  /// begin().
  void refuse(const RunStatus& status);

  /// Writes how the sweep ended into status.json, and the finished rows into sweep.csv and sweep.json. Throws
  /// RuntimeFault if that fails.
  void finish(pusht::ExitCode code, const std::string& reason);

  /// Metrics of the finished rows, each with its number under "row".
  const std::vector<nlohmann::json>& rows() const { return rows_; }

  /// Folder of the reference's rollouts while the sweep is under way, for a sweep without another cache.
  std::filesystem::path referencePath() const { return referenceFolder(path()); }
  void removeReference() const { folder_.removeReference(); }

  const std::filesystem::path& path() const { return folder_.path(); }

 private:
  std::filesystem::path createRow(std::size_t index) const;
  void writeTables() const;
  void writeStatus(pusht::ExitCode code, const std::string& reason) const;

  OutputFolder folder_;
  bool overwrite_;
  nlohmann::json description_;
  std::vector<nlohmann::json> rows_;
};

/// Number of a row as text: "row 0 of 0 to 2". Rows count from 0, as their folders.
std::string rowText(std::size_t index, std::size_t rows);

/// Runs `body`, writes its end into status.json of the sweep, and rethrows what it throws.
template <class Body>
void withStatus(SweepFolder& folder, std::ostream& out, const Body& body) {
  try {
    body();
  } catch (const std::exception& failure) {
    try {
      folder.finish(pusht::exitCodeOf(failure), pusht::reasonOf(failure));
    } catch (const pusht::RuntimeFault&) {
      // The first failure is the one to report.
    }
    throw;
  }
  folder.finish(pusht::ExitCode::kOk, "finished");
  out << "results: " << folder.path().string() << std::endl;
}

}  // namespace sim2sim
