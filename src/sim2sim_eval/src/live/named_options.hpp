// SPDX-License-Identifier: BSD-3-Clause
/// The options of a run by name, as messages: described for forms, and taken from goals.
#pragma once

#include <pusht_msgs/CompareGoal.h>
#include <pusht_msgs/RunOptions.h>

#include <cstddef>
#include <string>

#include "sim2sim_protocol/run_options.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace sim2sim {

/// Every option with its descriptor and its value in `options`. A list is a text, "1,5,20" or "none"; a share that may
/// be absent is a real, 0 where it is.
pusht_msgs::RunOptions describe(const RunOptions& options);

/// Throws InvalidInput, with the field's name, unless a field of a goal has one value or none.
void requireOneOrNone(const std::string& name, std::size_t values);

/// What `goal` says in the fields that some options have from the time before they were named, by name. These fields
/// are read in this release and go in the next. Throws InvalidInput for a field of more than one value that is no list.
pusht::Parameters oldFields(const pusht_msgs::CompareGoal& goal);

/// Whether `goal` says anything of the option `name`: by name or in an old field.
bool names(const pusht_msgs::CompareGoal& goal, const std::string& name);

/// Sets the options of which `goal` says something. Throws InvalidInput with name, value and rule for an option that is
/// unknown, is said twice, or has a value that it does not take.
void setNamed(RunOptions& options, const pusht_msgs::CompareGoal& goal);

}  // namespace sim2sim
