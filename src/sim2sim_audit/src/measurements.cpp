// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_audit/measurements.hpp"

#include <stdexcept>

namespace sim2sim {

double Measurements::need(Property property) const {
  const Estimate& estimate = (*this)[property];
  if (!estimate.value) {
    throw std::runtime_error(std::string("needs ") + describe(property).title + ": " + estimate.problem);
  }
  return *estimate.value;
}

}  // namespace sim2sim
