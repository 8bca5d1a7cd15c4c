// SPDX-License-Identifier: BSD-3-Clause
/// Audit: do two worlds keep one contract, and have they the same physics? Each property is estimated in both and held
/// against how much the reference's own model variants differ in it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pusht_task/policy.hpp"
#include "sim2sim_audit/bench.hpp"
#include "sim2sim_audit/measurements.hpp"

namespace sim2sim {

/// World to be audited, by its maker. Each world is measured by one thread.
struct AuditedWorld {
  std::string title;  ///< for people: "MuJoCo"
  WorldFactory make;  ///< called once more for a second world
  /// What its kind does otherwise than the task on purpose: keys of properties.
  std::vector<std::string> departures{};
};

/// What a comparison of a property says.
enum class PropertyVerdict { kSame, kDiffers, kCannotTell };

/// "same", "differs", "cannot tell".
const char* nameOf(PropertyVerdict verdict);

/// Comparison of one property.
struct Comparison {
  Property property;
  PropertyVerdict verdict;
  std::optional<double> reference;  ///< in the property's unit; infinity: there is none
  std::optional<double> engine;
  double allowed = 0.0;        ///< greatest difference that is the same, in the property's unit
  std::string held_against{};  ///< what `allowed` is: "model variants", "start tolerance", "resolution", "fit"
  double effect = 0.0;         ///< [m] estimated share in the divergence after 5 control steps; 0 unless it differs
  std::string reason{};        ///< why nothing can be told; empty otherwise
  bool is_declared = false;    ///< whether a kind of one of the worlds says that it does so on purpose

  /// Whether it is an error: a difference in the contract that is not declared.
  bool isContractError() const { return verdict == PropertyVerdict::kDiffers && isContract(property) && !is_declared; }
  double difference() const { return *engine - *reference; }
};

/// Result of an audit.
struct Audit {
  std::string reference;              ///< title
  std::string engine;                 ///< title
  std::vector<std::string> variants;  ///< titles of the reference's model variants
  std::uint64_t seed = 0;
  std::vector<Comparison> comparisons;  ///< of all properties, in their order
  /// [m] Mean divergence in short replays of a policy in the engine (replay.hpp); none if there were none.
  std::optional<double> divergence{};

  /// Differences, the worst first: errors of the contract, then the others by effect.
  std::vector<Comparison> findings() const;
  /// Whether a finding is an error of the contract. What a kind declares is none.
  bool hasContractErrors() const;
};

/// Compares what was measured in two worlds. `variants` are the reference's model variants; `departures` the keys of
/// properties in which one of the worlds differs from the `task` on purpose. Throws InvalidInput for an unknown key.
Audit compare(const Measurements& reference, const Measurements& engine, const std::vector<Measurements>& variants,
              double start_tolerance, const std::vector<std::string>& departures = {},
              const pusht::Task& task = pusht::fullCircle());

/// Measures all worlds, on up to `threads` threads, and compares. Where there is a `policy`, its actions in the
/// reference are replayed in the engine. The bytes of the result do not depend on `threads`.
Audit audit(const AuditedWorld& reference, const AuditedWorld& engine, const std::vector<AuditedWorld>& variants,
            std::uint64_t seed, int threads, pusht::Policy* policy = nullptr);

/// Likely cause of a finding in words, with what to look at: "acts 1 control step late: ...".
std::string causeOf(const Comparison& finding);

/// One screen of text: the findings, what cannot be told, and what is the same.
std::string textOf(const Audit& audit);

}  // namespace sim2sim
