// SPDX-License-Identifier: BSD-3-Clause
/// The options of a run by name, as messages: described for forms, and taken from goals.
#pragma once

#include <pusht_msgs/CompareGoal.h>
#include <pusht_msgs/RunOptions.h>

#include <string>
#include <type_traits>

#include "sim2sim_protocol/run_options.hpp"

namespace sim2sim {

/// Every option with its descriptor and its value in `options`. A list is a text, "1,5,20" or "none"; a share that may
/// be absent is a real, 0 where it is.
pusht_msgs::RunOptions describe(const RunOptions& options);

/// Calls function(option) for each option that a Goal has as a field of its name. It has the others by name alone.
template <class Goal, class Function>
void forEachField(const Function& function) {
  forEachOption([&](const auto& option) {
    if constexpr (std::is_invocable_v<decltype(option.of), Goal&>) {
      function(option);
    }
  });
}

/// Whether `goal` says anything of the option `name`: in its field or by name.
bool names(const pusht_msgs::CompareGoal& goal, const std::string& name);

/// Sets the options that `goal` has by name. Throws InvalidInput with name, value and rule for an option that is
/// unknown, is named twice or beside its field, or has a value that it does not take.
void setNamed(RunOptions& options, const pusht_msgs::CompareGoal& goal);

}  // namespace sim2sim
