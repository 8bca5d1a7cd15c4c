// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/result_files.hpp"

#include <algorithm>
#include <string>

namespace sim2sim {

namespace fs = std::filesystem;

fs::path rowsFolder(const fs::path& sweep) { return sweep / "rows"; }

fs::path rowFolder(const fs::path& sweep, std::size_t row) {
  constexpr std::size_t kDigits = 3;
  std::string name = std::to_string(row);
  name.insert(0, kDigits - std::min(name.size(), kDigits), '0');
  return rowsFolder(sweep) / name;
}

fs::path referenceFolder(const fs::path& sweep) { return sweep / "reference"; }

}  // namespace sim2sim
