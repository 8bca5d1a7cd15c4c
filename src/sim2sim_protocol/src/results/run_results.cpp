// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/run_results.hpp"

#include <cstddef>
#include <exception>
#include <system_error>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/json_text.hpp"
#include "sim2sim_protocol/results/difference.hpp"
#include "sim2sim_protocol/results/episodes_csv.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

[[noreturn]] void refuse(const fs::path& path, const std::string& why) {
  throw pusht::InvalidInput("results " + path.string() + ": " + why);
}

bool isThere(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

void requireSweepOrRun(const fs::path& folder) {
  if (!isThere(folder / kMetricsFile) && !isThere(folder / kSweepFile)) {
    refuse(folder, "must be the folder of a whole run or of a sweep");
  }
}

/// Option that belongs to a policy more than to a run.
constexpr const char* kExecute = "execute";

/// Option that starts are let through with; they are the same with and without it.
constexpr const char* kOverlapping = "overlapping_starts";

/// Keys of metrics.json in which all runs that pair agree, as JSON pointers.
std::vector<std::string> commonPlaces() {
  std::vector<std::string> places;
  forEachOption([&](const auto& option) {
    const std::string name = option.name;
    if (option.written != Written::kElsewhere && name != kExecute && name != kOverlapping) {
      places.push_back(std::string("/") + option.name);
    }
  });
  places.insert(places.end(), {"/starts", "/smoke", "/probes", "/simulators/reference"});
  return places;
}

/// First difference of two runs in one of these places; empty without one.
std::string differenceIn(const std::vector<std::string>& places, const RunResults& baseline, const RunResults& other) {
  for (const std::string& key : places) {
    const json::json_pointer place(key);
    const json one = baseline.metrics.value(place, json());
    const json two = other.metrics.value(place, json());
    if (one != two) {
      return key.substr(1) + firstDifference(one, two, " and ");
    }
  }
  return "";
}

/// How the policies of two runs differ; empty if they do not, as far as their folders say.
std::string differenceOfPolicies(const RunResults& baseline, const RunResults& other) {
  std::string difference = differenceIn({"/policy", std::string("/") + kExecute}, baseline, other);
  const bool are_files = !baseline.policy_sha256.empty() && !other.policy_sha256.empty();
  if (difference.empty() && are_files && baseline.policy_sha256 != other.policy_sha256) {
    return "policy has sha256 " + baseline.policy_sha256 + " and " + other.policy_sha256;
  }
  return difference;
}

/// Digest of the policy's file, if the folder of a run says it.
std::string policyDigest(const fs::path& folder) {
  if (!isThere(folder / kProvenanceFile)) {
    return "";
  }
  const json provenance = pusht::parseJson(pusht::readFile(folder / kProvenanceFile, "results"));
  const json digest = provenance.is_object() ? provenance.value(json::json_pointer("/policy/sha256"), json()) : json();
  return digest.is_string() ? digest.get<std::string>() : "";
}

[[noreturn]] void refusePair(const RunResults& baseline, const RunResults& other, const std::string& why) {
  throw pusht::InvalidInput(baseline.folder.string() + " and " + other.folder.string() + ": do not pair: " + why);
}

bool sameReference(const EpisodeResult& a, const EpisodeResult& b) {
  const RolloutResult& one = a.rollouts[kReferenceClosed];
  const RolloutResult& other = b.rollouts[kReferenceClosed];
  return one.steps == other.steps && one.success == other.success &&
         one.at("final_position_error") == other.at("final_position_error") &&
         one.at("final_angle_error") == other.at("final_angle_error");
}

}  // namespace

std::string RunResults::title() const { return titleOf(simulatorFrom(metrics.at("simulators").at("engine"))); }

std::string RunResults::policy() const { return metrics.value("policy", ""); }

const json& RunResults::engine() const { return metrics.at("simulators").at("engine"); }

RunResults readResults(const fs::path& folder) {
  RunResults results{folder, {}, {}, {}, policyDigest(folder)};
  results.metrics = pusht::parseJson(pusht::readFile(folder / kMetricsFile, "results"));
  if (!results.metrics.is_object()) {
    refuse(folder / kMetricsFile, "must be a JSON object");
  }
  try {
    results.protocol = protocolFrom(results.metrics);
    results.title();
  } catch (const std::exception& error) {
    refuse(folder / kMetricsFile, std::string("must be that of a whole run: ") + error.what());
  }
  try {
    results.episodes = episodesFromCsv(results.protocol, pusht::readFile(folder / kEpisodesFile, "results"));
  } catch (const pusht::InvalidInput& error) {
    refuse(folder / kEpisodesFile, error.what());
  }
  if (static_cast<int>(results.episodes.size()) != results.protocol.episodes) {
    refuse(folder / kEpisodesFile, "has " + std::to_string(results.episodes.size()) + " episodes, must have " +
                                       std::to_string(results.protocol.episodes) + " as metrics.json says");
  }
  return results;
}

void SweepResults::requireWhole() const {
  if (description.contains("shard")) {
    refuse(folder, "is shard " + description.at("shard").dump() + " of a sweep; merge the shards first");
  }
}

json SweepResults::provenance() const {
  json content = pusht::parseJson(pusht::readFile(folder / kProvenanceFile, "results"));
  if (!content.is_object()) {
    refuse(folder / kProvenanceFile, "must be a JSON object");
  }
  return content;
}

std::vector<fs::path> SweepResults::rowFolders() const {
  const json listed = description.value("rows", json());
  const std::size_t count = listed.is_array() ? listed.size() : 0;
  if (count == 0) {
    refuse(folder / kSweepFile, "must be that of a sweep");
  }
  std::vector<fs::path> rows;
  for (std::size_t row = 0; row < count; ++row) {
    rows.push_back(rowFolder(folder, row));
    if (!isThere(rows.back() / kMetricsFile)) {
      refuse(folder, "row " + std::to_string(row) + " of " + std::to_string(count) +
                         " has not finished; run the sweep again to continue it");
    }
  }
  return rows;
}

std::vector<RunResults> SweepResults::readRows(const std::function<void()>& go_on) const {
  std::vector<RunResults> rows;
  for (const fs::path& row : rowFolders()) {
    go_on();
    rows.push_back(readResults(row));
  }
  return rows;
}

SweepResults readSweep(const fs::path& folder) {
  const fs::path file = folder / kSweepFile;
  const json content = pusht::parseJson(pusht::readFile(file, "results"));
  json sweep = content.is_object() ? content.value("sweep", json()) : json();
  if (!sweep.is_object()) {
    refuse(file, "must be that of a sweep");
  }
  return {folder, std::move(sweep)};
}

SweepResults readWholeSweep(const fs::path& folder, const std::string& needed) {
  requireSweepOrRun(folder);
  if (isThere(folder / kMetricsFile)) {
    refuse(folder, "is a run; " + needed + " is needed");
  }
  SweepResults sweep = readSweep(folder);
  sweep.requireWhole();
  return sweep;
}

std::vector<fs::path> runsIn(const fs::path& folder) {
  requireSweepOrRun(folder);
  return isThere(folder / kMetricsFile) ? std::vector<fs::path>{folder} : readSweep(folder).rowFolders();
}

Pairing pairingOf(const RunResults& baseline, const RunResults& other) {
  if (baseline.protocol.alone != other.protocol.alone) {
    refusePair(baseline, other, "one of them has no engine");
  }
  if (const std::string difference = differenceIn(commonPlaces(), baseline, other); !difference.empty()) {
    refusePair(baseline, other, difference);
  }
  const std::string of_policies = differenceOfPolicies(baseline, other);
  if (!of_policies.empty()) {
    const std::string of_engines = differenceIn({"/simulators/engine"}, baseline, other);
    if (!of_engines.empty()) {
      refusePair(baseline, other,
                 of_policies + ", and " + of_engines +
                     "; one of both must be the same (`matrix` takes a sweep over "
                     "both)");
    }
    if (baseline.protocol.until_decided) {
      refusePair(baseline, other,
                 "they end when a share is decided; a difference of policies needs runs of a fixed length");
    }
    return Pairing::kPolicies;
  }
  if (baseline.protocol.alone) {
    refusePair(baseline, other, "they have the same policy, and no engine: nothing differs");
  }
  for (std::size_t i = 0; i < baseline.episodes.size(); ++i) {
    if (!sameReference(baseline.episodes[i], other.episodes[i])) {
      const bool are_told_apart = !baseline.policy_sha256.empty() && !other.policy_sha256.empty();
      refusePair(baseline, other,
                 "the reference did not do the same in episode " + std::to_string(baseline.episodes[i].index) +
                     (are_told_apart ? "" : ", or another policy has the name " + baseline.policy()));
    }
  }
  return Pairing::kEngines;
}

void requirePairs(const RunResults& baseline, const RunResults& other) {
  if (pairingOf(baseline, other) != Pairing::kEngines) {
    refusePair(baseline, other, differenceOfPolicies(baseline, other));
  }
}

}  // namespace sim2sim
