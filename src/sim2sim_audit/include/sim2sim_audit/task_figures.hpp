// SPDX-License-Identifier: BSD-3-Clause
/// The task's own figures as a reference of audits: so a single simulator can be audited.
#pragma once

#include "pusht_task/task.hpp"
#include "sim2sim_audit/audit.hpp"
#include "sim2sim_audit/measurements.hpp"

namespace sim2sim {

/// Name of the task in place of a reference: "the task".
constexpr const char* kTaskTitle = "the task";

/// What an audit finds in a world that keeps the contract and has the task's physics. What the task leaves open, such
/// as the softness of contacts, has no value.
Measurements figuresOf(const pusht::Task& task);

/// Audit of one world against its task.
Audit auditAgainstTask(const AuditedWorld& world, std::uint64_t seed);

}  // namespace sim2sim
