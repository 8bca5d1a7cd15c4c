// SPDX-License-Identifier: BSD-3-Clause
/// Bullet's shared libraries, as this process has loaded them.
#pragma once

#include <string>

namespace pusht::bullet {

/// Version of the library, e.g. "3.24": its file name has it, no function of it does.
std::string libraryVersion();

/// Throws BadDependency if Bullet in single precision is loaded too: both builds have the same symbols.
void requireOneBuild();

}  // namespace pusht::bullet
