// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace pusht {

/// Of the library, e.g. "7.0.3".
std::string chipmunkVersion();

}  // namespace pusht
