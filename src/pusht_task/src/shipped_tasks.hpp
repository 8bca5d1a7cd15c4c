// SPDX-License-Identifier: BSD-3-Clause
/// The tasks that come with the suite, by name.
#pragma once

#include <string>

#include "pusht_task/task.hpp"

namespace pusht {

/// Whether a task of this name comes with the suite.
bool isShippedTask(const std::string& name);

/// The one of this name. Throws InvalidInput with the known ones if there is none.
const Task& shippedTask(const std::string& name);

}  // namespace pusht
