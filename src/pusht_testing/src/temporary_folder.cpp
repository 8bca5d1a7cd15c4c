// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_testing/temporary_folder.hpp"

#include <cstdlib>
#include <stdexcept>
#include <system_error>

namespace pusht::testing {

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "pusht_").string() + std::string(6, 'X');
  if (mkdtemp(name.data()) == nullptr) {
    throw std::runtime_error("cannot create " + name);
  }
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace pusht::testing
