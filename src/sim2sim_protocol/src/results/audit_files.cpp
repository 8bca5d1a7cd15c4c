// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/audit_files.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/json_text.hpp"
#include "sim2sim_protocol/reference_cache.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/result_files.hpp"

namespace sim2sim {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

namespace fs = std::filesystem;

/// "format" of a kept verdict.
std::string formatText() { return "audit verdict " + std::to_string(kVerdictFormat); }

bool areTexts(const json& value) {
  return value.is_array() &&
         std::all_of(value.begin(), value.end(), [](const json& element) { return element.is_string(); });
}

}  // namespace

std::string auditText(const ordered_json& audit, const std::optional<SimulatorRecord>& reference,
                      const SimulatorRecord& engine) {
  constexpr int kIndent = 2;
  ordered_json file = {{"format", kAuditFormat}};
  file.update(audit);
  file["simulators"] = {{"reference", reference ? toJson(*reference) : ordered_json()}, {"engine", toJson(engine)}};
  return file.dump(kIndent) + "\n";
}

KeptVerdict::KeptVerdict(const fs::path& folder, json key)
    : key_(std::move(key)), file_(folder / (keptName(key_) + ".json")) {}

std::optional<std::vector<std::string>> KeptVerdict::find() const {
  std::error_code ignored;
  if (fs::symlink_status(file_, ignored).type() == fs::file_type::not_found) {
    return std::nullopt;
  }
  const std::string remedy = "; delete it and audit the pair again";
  const auto refuse = [&](const std::string& why) {
    throw pusht::BadDependency("kept audit " + file_.string() + ": " + why + remedy);
  };
  std::string text;
  try {
    text = pusht::readFile(file_, "kept audit", pusht::kLargestSmallFile);
  } catch (const pusht::InvalidInput& error) {
    throw pusht::BadDependency(std::string(error.what()) + remedy);
  }
  const json content = pusht::parseJson(text);
  const json format = content.is_object() ? content.value("format", json()) : json();
  if (format.is_string() && format != formatText()) {
    refuse("format " + format.dump() + ": must be \"" + formatText() + "\"; another version of the suite wrote it");
  }
  if (format != formatText()) {
    refuse("must be an \"" + formatText() + "\"");
  }
  if (content.value("key", json()) != key_) {
    refuse("belongs to another pair: its key is not that of its name");
  }
  const json errors = content.value("contract_errors", json());
  if (!areTexts(errors) || content.value("sha256", json()) != pusht::sha256(errors.dump())) {
    refuse("is damaged: its verdict is not the one that was written");
  }
  return errors.get<std::vector<std::string>>();
}

void KeptVerdict::keep(const std::vector<std::string>& contract_errors) const {
  std::error_code error;
  fs::create_directories(file_.parent_path(), error);
  if (error) {
    throw pusht::RuntimeFault("cannot create " + file_.parent_path().string() + ": " + error.message());
  }
  const json content = {{"format", formatText()},
                        {"key", key_},
                        {"contract_errors", contract_errors},
                        {"sha256", pusht::sha256(json(contract_errors).dump())}};
  pusht::writeCacheFile(file_, jsonText(content));
}

}  // namespace sim2sim
