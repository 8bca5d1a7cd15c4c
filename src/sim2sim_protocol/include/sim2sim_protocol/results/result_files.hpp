// SPDX-License-Identifier: BSD-3-Clause
/// Names and formats of the files of results. The table is src/sim2sim_protocol/result_files.json, which Python reads
/// too (sim2sim_protocol.result_files). An unknown key does not compile.
#pragma once

#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string_view>

#include "sim2sim_protocol/results/result_file_table.hpp"

namespace sim2sim {

/// A file by its key. Throws std::out_of_range for an unknown key.
constexpr const ResultFile& resultFile(std::string_view key) {
  for (const ResultFile& file : kResultFiles) {
    if (key == file.key) {
      return file;
    }
  }
  throw std::out_of_range("no such result file");
}

// Names of files in their folder.
inline constexpr const char* kMetricsFile = resultFile("metrics").name;
inline constexpr const char* kStatisticsFile = resultFile("statistics").name;
inline constexpr const char* kBandsFile = resultFile("bands").name;
inline constexpr const char* kEpisodesFile = resultFile("episodes").name;
inline constexpr const char* kJournalFile = resultFile("journal").name;
inline constexpr const char* kBagFile = resultFile("bag").name;
inline constexpr const char* kTracesFile = resultFile("traces").name;
inline constexpr const char* kSweepFile = resultFile("sweep").name;
inline constexpr const char* kSweepTable = resultFile("sweep_table").name;
inline constexpr const char* kAttributionFile = resultFile("attribution").name;
inline constexpr const char* kAttributionTable = resultFile("attribution_table").name;
inline constexpr const char* kMatrixFile = resultFile("matrix").name;
inline constexpr const char* kMatrixTable = resultFile("matrix_table").name;
inline constexpr const char* kEquivalentFile = resultFile("equivalent").name;
inline constexpr const char* kEquivalentTable = resultFile("equivalent_table").name;
inline constexpr const char* kReportFile = resultFile("report").name;
inline constexpr const char* kProvenanceFile = resultFile("provenance").name;
inline constexpr const char* kStatusFile = resultFile("status").name;

// Numbers of formats. A reader refuses a file of another format.
inline constexpr int kDescriptionFormat = resultFile("metrics").format;
inline constexpr int kStatisticsFormat = resultFile("statistics").format;
inline constexpr int kJournalFormat = resultFile("journal").format;
inline constexpr int kAttributionFormat = resultFile("attribution").format;
inline constexpr int kMatrixFormat = resultFile("matrix").format;
inline constexpr int kEquivalentFormat = resultFile("equivalent").format;
inline constexpr int kContrastFormat = resultFile("contrast").format;
inline constexpr int kAgreementFormat = resultFile("agreement").format;
inline constexpr int kAuditFormat = resultFile("audit").format;
inline constexpr int kPolicyAuditFormat = resultFile("policy_audit").format;
inline constexpr int kRolloutFormat = resultFile("rollout").format;
inline constexpr int kStatusFormat = resultFile("status").format;

/// Folder of all rows of a sweep.
std::filesystem::path rowsFolder(const std::filesystem::path& sweep);

/// Folder of a row of a sweep: rows/007.
std::filesystem::path rowFolder(const std::filesystem::path& sweep, std::size_t row);

/// Folder in which a sweep keeps its reference until it is finished.
std::filesystem::path referenceFolder(const std::filesystem::path& sweep);

}  // namespace sim2sim
