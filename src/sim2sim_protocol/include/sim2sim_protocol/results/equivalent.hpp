// SPDX-License-Identifier: BSD-3-Clause
/// Equivalents of a gap: how large an error of one parameter of the reference, or of the loop between policy and
/// reference, costs as much success as changing to the engine does.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_statistics/equivalence.hpp"

namespace sim2sim {

/// Success in the reference with an error of one size.
struct ErrorLevel {
  double size;  ///< value of the parameter, in its unit
  SuccessRate success;
};

/// One parameter as the error that costs as much as the engine does.
struct Equivalent {
  std::string parameter;           ///< "loop.action_delay", or a parameter of the reference
  std::string unit;                ///< empty: none
  double without;                  ///< its value in the reference itself
  std::vector<ErrorLevel> levels;  ///< away from `without`, which is the first
  /// First distance from `without` at which success is shown to be above that without an error. Then success has no
  /// slope to be read, and `error` says nothing. Empty: none.
  std::optional<double> rises_at{};
  /// Distance from `without`, in the parameter's unit; of an integer the nearest whole one.
  EquivalentSize error{};
};

/// One engine with its equivalents.
struct EngineEquivalents {
  std::string engine;  ///< title
  SuccessRate success;
  Surplus lost;  ///< success of the reference, less that of the engine; size 0
  std::vector<Equivalent> equivalents{};
};

/// Equivalents of all engines of a sweep.
struct Equivalents {
  std::string reference;  ///< title
  std::string policy;
  int episodes;
  std::vector<EngineEquivalents> engines;
};

/// Reads the sweep in `folder`. Its rows in the reference's kind that differ from the reference in one number alone are
/// the sizes of an error; a parameter with sizes on both sides of the reference's value counts as two. All other rows
/// are engines. Throws InvalidInput with file and rule if `folder` is no whole sweep, has several policies, or has no
/// engine or no error. Calls `go_on` before each row that it reads; it may throw to end the work.
Equivalents readEquivalents(const std::filesystem::path& folder, const std::function<void()>& go_on);

}  // namespace sim2sim
