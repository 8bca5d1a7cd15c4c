// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/installed_file.hpp"

#include <ros/package.h>

#include <system_error>

#include "pusht_task/error.hpp"

namespace pusht {

std::filesystem::path installedFile(const std::string& package, const std::string& relative_path) {
  const std::string share = ros::package::getPath(package);
  if (share.empty()) {
    throw BadDependency("package " + package + " is not found: source the workspace's setup.bash");
  }
  std::filesystem::path path = std::filesystem::path(share) / relative_path;
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    throw BadDependency(path.string() + " is missing: package " + package + " must install it");
  }
  return path;
}

}  // namespace pusht
