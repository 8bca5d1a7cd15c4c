// SPDX-License-Identifier: BSD-3-Clause
/// Paths of files that packages of the suite install.
#pragma once

#include <filesystem>
#include <string>

namespace pusht {

/// A file that a package of the suite installs; needs no master. Throws BadDependency, naming it, if there is none.
std::filesystem::path installedFile(const std::string& package, const std::string& relative_path);

}  // namespace pusht
