// SPDX-License-Identifier: BSD-3-Clause
/// What a command derives from a finished sweep, as two files in its folder: JSON and a table.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sim2sim {

/// Writer of the two files: both are written aside before the first is moved into place. The JSON is moved last, so it
/// is there only beside a table of its own.
class DerivedFiles {
 public:
  /// `what` names them in messages: "attribution". Throws InvalidInput if one of them is there, unless `overwrite`.
  DerivedFiles(const std::string& what, const std::filesystem::path& folder, const char* json_name,
               const char* table_name, bool overwrite);

  /// Throws RuntimeFault if one of them is there by now, unless `overwrite`, or if they cannot be written.
  void write(const nlohmann::json& json, const std::string& table) const;

 private:
  std::string what_;
  std::filesystem::path json_;
  std::filesystem::path table_;
  bool overwrite_;
};

}  // namespace sim2sim
