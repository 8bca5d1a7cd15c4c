// SPDX-License-Identifier: BSD-3-Clause
/// The folder that holds a sweep, or a shard of one.
#pragma once

#include <cstddef>
#include <exception>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/reason.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/results/journal.hpp"
#include "sim2sim_protocol/results/output_folder.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"
#include "sim2sim_protocol/results/summary.hpp"

namespace sim2sim {

/// A sweep that is on disk: rows/000/metrics.json and episodes.csv (those of a run with its knobs), rows/001/..., and
/// sweep.json, which says what the sweep is. Files are complete or absent.
struct SweepOnDisk {
  std::filesystem::path folder;
  nlohmann::json description;
  nlohmann::json provenance;  ///< its "code" is that of the build; "format" as in the description
};

/// Throws InvalidInput if there is no sweep in the folder.
SweepOnDisk readSweep(const std::filesystem::path& folder);

/// What is read of a shard.
std::vector<Input> inputsOf(const std::filesystem::path& shard);

/// In what two sweeps, or the builds that run them, differ first, with both values: "/seed is 1, must be 0". Empty if
/// in nothing.
std::string differenceOf(const SweepOnDisk& found, const SweepOnDisk& wanted);

/// A finished row: its episodes, and what they say.
struct SweepRow {
  SweepRow(const RunConfiguration& configuration, std::vector<EpisodeResult> results);

  std::vector<EpisodeResult> episodes;
  Summary summary;
  nlohmann::json metrics;
};

/// A row of the sweep in `folder`; none if it is not finished. Throws BadDependency, naming the file, if its episodes
/// are not as they were written or not those of `configuration`.
std::optional<SweepRow> readRow(const std::filesystem::path& folder, std::size_t index,
                                const RunConfiguration& configuration);

/// Writes a sweep.
class SweepFolder {
 public:
  /// As OutputFolder.
  SweepFolder(std::filesystem::path path, bool overwrite, std::string command);

  /// As OutputFolder.
  void refuseInputs(const std::vector<Input>& inputs) const { folder_.refuseInputs(inputs); }

  /// Begins the sweep that `description` says, or goes on with it if the folder holds it. Throws InvalidInput if the
  /// folder holds results that must stay; as OutputFolder::open() otherwise.
  void begin(const nlohmann::json& description, const nlohmann::json& provenance);

  /// The journal of a row that is run; keep() and resume() remove it. Throws as Journal does.
  Journal journal(std::size_t index, const RunConfiguration& configuration) const;

  /// Writes a row; rows come in order. Throws RuntimeFault if it cannot be written.
  void keep(std::size_t index, const RunConfiguration& configuration, const SweepRow& row);

  /// The same for a row that is on disk already.
  void resume(std::size_t index, nlohmann::json metrics);

  /// Only says why the sweep does not begin, or go on; not beside a sweep, whose status stays. Throws as begin() does.
  void refuse(const RunStatus& status);

  /// Says how the sweep ended: status.json, and sweep.csv and sweep.json with the rows that there are. Throws
  /// RuntimeFault if they cannot be written.
  void finish(pusht::ExitCode code, const std::string& reason);

  /// The metrics of the finished rows, each with its number as "row".
  const std::vector<nlohmann::json>& rows() const { return rows_; }

  /// Where the sweep keeps its reference until it is finished, if it has no other cache.
  std::filesystem::path referencePath() const { return path() / "reference"; }
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

/// "row 0 of 0 to 2": rows are counted as their folders are.
std::string rowText(std::size_t index, std::size_t rows);

/// Runs `body`; whatever its end, status.json of the sweep tells it.
template <class Body>
void withStatus(SweepFolder& folder, const Body& body) {
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
  std::cout << "results: " << folder.path().string() << std::endl;
}

}  // namespace sim2sim
