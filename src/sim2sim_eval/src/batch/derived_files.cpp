// SPDX-License-Identifier: BSD-3-Clause
#include "batch/derived_files.hpp"

#include <nlohmann/json.hpp>
#include <system_error>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "sim2sim_protocol/results/json.hpp"

namespace sim2sim {

DerivedFiles::DerivedFiles(const std::string& what, const std::filesystem::path& folder, const char* json_name,
                           const char* table_name, bool overwrite)
    : what_(what), json_(folder / json_name), table_(folder / table_name), overwrite_(overwrite) {
  for (const std::filesystem::path& path : {table_, json_}) {
    std::error_code ignored;
    if (!overwrite && std::filesystem::symlink_status(path, ignored).type() != std::filesystem::file_type::not_found) {
      throw pusht::InvalidInput(what + " " + path.string() + ": is there already; replace it with --overwrite");
    }
  }
}

void DerivedFiles::write(const nlohmann::json& json, const std::string& table) const {
  pusht::AsideFile new_table(table_);
  pusht::AsideFile new_json(json_);
  new_table.write(table, true);
  new_json.write(jsonText(json), true);
  if (overwrite_) {
    new_table.moveIntoPlace();
    new_json.moveIntoPlace();
    return;
  }
  new_table.moveIntoNewPlace(what_);
  try {
    new_json.moveIntoNewPlace(what_);
  } catch (const pusht::Error&) {
    std::error_code ignored;
    std::filesystem::remove(table_, ignored);  // both or none
    throw;
  }
}

}  // namespace sim2sim
