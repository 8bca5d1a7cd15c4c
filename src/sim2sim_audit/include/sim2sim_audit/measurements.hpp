// SPDX-License-Identifier: BSD-3-Clause
/// What an audit has found in one world.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "sim2sim_audit/property.hpp"

namespace sim2sim {

/// What was measured of one property. Infinity stands for "there is none", such as a wall or a limit.
struct Measurement {
  std::optional<double> value{};
  double uncertainty = 0.0;  ///< in the property's unit, from what the fit left over; 0 for a closed form
  std::string problem{};     ///< why there is no value; empty if there is one
};

/// Estimates of all properties of one world.
class Measurements {
 public:
  const Measurement& operator[](Property property) const { return estimates_[index(property)]; }

  /// Sets a value; NaN is a problem and no value.
  void set(Property property, double value, double uncertainty = 0.0);
  /// States why a property has no value. A value that is there stays.
  void fail(Property property, std::string problem);
  /// Takes a value back that a later experiment shows to be none, and states why.
  void withdraw(Property property, std::string problem);
  /// Value of a property that another experiment needs. Throws std::runtime_error that names it if there is none.
  double need(Property property) const;

 private:
  static std::size_t index(Property property) { return static_cast<std::size_t>(property); }

  std::array<Measurement, kPropertyCount> estimates_{};
};

}  // namespace sim2sim
