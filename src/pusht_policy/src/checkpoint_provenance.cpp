// SPDX-License-Identifier: BSD-3-Clause
#include "checkpoint_provenance.hpp"

#include <nlohmann/json.hpp>
#include <system_error>

#include "pusht_policy/checkpoint_home.hpp"
#include "pusht_policy/formats.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/json_text.hpp"

namespace pusht {

void requireHashOfProvenance(const std::filesystem::path& path, const std::string& name, const std::string& sha256) {
  const std::filesystem::path provenance = provenancePath(path);
  std::error_code error;
  const auto type = std::filesystem::symlink_status(provenance, error).type();
  if (type == std::filesystem::file_type::not_found || error == std::errc::filename_too_long) {
    return;
  }
  const std::string text = readFile(provenance, "provenance", kLargestSmallFile);
  nlohmann::json format = kProvenanceFormat;
  std::string expected;
  try {
    const nlohmann::json content = parseJson(text);
    format = content.value("format", format);
    expected = content.at("checkpoint").at("sha256").get<std::string>();
  } catch (const nlohmann::json::exception&) {
    expected.clear();
  }
  if (format != kProvenanceFormat) {
    throw InvalidInput("provenance " + provenance.string() + ": format is " + format.dump() + ", must be " +
                       std::to_string(kProvenanceFormat) + "; another version of the suite wrote it");
  }
  if (expected.size() != sha256.size() || expected.find_first_not_of("0123456789abcdef") != std::string::npos) {
    throw InvalidInput("provenance " + provenance.string() + ": must be JSON with a checkpoint.sha256 of " +
                       std::to_string(sha256.size()) + " hex digits");
  }
  if (sha256 != expected) {
    throw BadDependency(name + ": its SHA-256 is " + sha256 + ", must be " + expected + " (" + provenance.string() +
                        ")");
  }
}

}  // namespace pusht
