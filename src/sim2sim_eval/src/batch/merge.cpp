// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstddef>
#include <filesystem>
#include <iostream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "batch/shard.hpp"
#include "batch/sweep_description.hpp"
#include "batch/sweep_folder.hpp"
#include "pusht_task/error.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Which shard a sweep is; it is then described as the whole. Throws BadDependency if it is none.
Shard takeShard(SweepResults& sweep) {
  const json shard = sweep.description.value("shard", json());
  if (!shard.is_string()) {
    throw pusht::BadDependency("shard " + sweep.folder.string() + ": is a sweep in one piece");
  }
  sweep.description.erase("shard");
  return Shard::from(shard.get<std::string>());
}

/// All shards of one sweep.
struct Shards {
  std::map<int, fs::path> folders;  // by number
  int of;
  json description;  // of the whole
  json provenance;
};

/// Throws InvalidInput if the shard is of another format.
SweepResults readShard(const fs::path& folder) {
  SweepResults sweep = readSweep(folder);
  for (const auto& [file, content] :
       {std::pair(kSweepFile, sweep.description), {kProvenanceFile, sweep.provenance()}}) {
    try {
      requireDescriptionFormat(content);
    } catch (pusht::Error& error) {
      error.addContext("shard " + (folder / file).string());
      throw;
    }
  }
  return sweep;
}

/// Throws BadDependency unless the folders hold all shards of one sweep, InvalidInput if one is of another format.
Shards requireShards(const std::vector<std::string>& folders) {
  SweepResults first = readShard(folders.front());
  const int of = takeShard(first).of;
  Shards shards{{}, of, first.description, first.provenance()};
  for (const std::string& folder : folders) {
    SweepResults sweep = readShard(folder);
    const Shard shard = takeShard(sweep);
    std::string difference = differenceOf(sweep, shards.description, shards.provenance);
    if (difference.empty() && shard.of != shards.of) {
      difference = "it is " + shard.text();
    }
    if (!difference.empty()) {
      throw pusht::BadDependency(
          std::string("shard ").append(folder).append(": is of another sweep than the first one: ").append(difference));
    }
    const auto [known, is_new] = shards.folders.emplace(shard.number, folder);
    if (!is_new) {
      throw pusht::BadDependency("shards " + known->second.string() + " and " + folder + ": are both " + shard.text());
    }
  }
  std::string missing;
  for (int number = 1; number <= shards.of; ++number) {
    if (shards.folders.count(number) == 0) {
      missing += (missing.empty() ? "" : ", ") + Shard{number, shards.of}.text();
    }
  }
  if (!missing.empty()) {
    throw pusht::BadDependency("shards " + missing + ": are missing");
  }
  return shards;
}

/// The runs that the rows are. Throws BadDependency if the description is not as it was written.
std::vector<RunConfiguration> checkedRows(const Shards& shards) {
  const std::string name =
      "shard " + shards.folders.begin()->second.string() + ": its sweep.json must be as it was written: ";
  try {
    return rowsOf(shards.description);
  } catch (const json::exception& error) {
    throw pusht::BadDependency(name + error.what());
  } catch (const pusht::InvalidInput& error) {
    throw pusht::BadDependency(name + error.what());
  }
}

/// The episodes of a row, from all shards.
std::vector<EpisodeResult> joinRow(const Shards& shards, const RunConfiguration& whole, std::size_t row) {
  std::vector<EpisodeResult> episodes;
  for (const auto& [number, folder] : shards.folders) {
    RunConfiguration part = whole;
    part.protocol = Shard{number, shards.of}.share(whole.protocol);
    const auto found = readRow(folder, row, part);
    if (!found) {
      throw pusht::BadDependency("shard " + folder.string() + ": row " + std::to_string(row) + " is not finished");
    }
    episodes.insert(episodes.end(), found->episodes.begin(), found->episodes.end());
  }
  return episodes;
}

/// Joins the shards of a sweep. The results have the bytes of the sweep in one piece. Throws as requireShards().
void mergeShards(const std::vector<std::string>& folders, const std::string& out, bool overwrite) {
  SweepFolder folder(out, overwrite, "merge");
  for (const std::string& shard : folders) {
    folder.refuseInputs(inputsOf(shard));
  }
  const Shards shards = requireShards(folders);
  const std::vector<RunConfiguration> rows = checkedRows(shards);
  loadFor(folder, [&] {  // damaged rows are found before anything is replaced
    for (std::size_t row = 0; row < rows.size(); ++row) {
      requireNotInterrupted("while " + rowText(row, rows.size()) + " was checked");
      joinRow(shards, rows[row], row);
    }
  });
  folder.begin(shards.description, shards.provenance);
  withStatus(folder, std::cout, [&] {
    for (std::size_t row = 0; row < rows.size(); ++row) {
      requireNotInterrupted("in " + rowText(row, rows.size()));
      folder.keep(row, rows[row], SweepRow(rows[row], joinRow(shards, rows[row], row)));
    }
  });
  if (shards.description.contains("policy")) {  // of several policies, each has its row in a matrix
    warn(doubtAboutPolicy(folder.rows().front(), shards.provenance));
  }
}

}  // namespace

int mergeMain(int argc, char** argv) {
  std::vector<std::string> shards;
  std::string out;
  bool overwrite = false;
  CLI::App app("Joins the shards of a sweep; the results are those of the sweep in one piece, byte for byte.", "merge");
  app.add_option("shards", shards, "folders of all shards of a sweep")->required()->check(notEmpty());
  app.add_option("--out", out, "folder for the results (default: the next free results/merge-N)")->check(notEmpty());
  app.add_flag("--overwrite", overwrite, "replace results that are in the folder already");
  return runCommand(app, argc, argv, [&] { mergeShards(shards, out, overwrite); });
}

}  // namespace sim2sim
