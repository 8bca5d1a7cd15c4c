// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_audit/measurements.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace sim2sim {

void Measurements::set(Property property, double value, double uncertainty) {
  if (std::isnan(value)) {
    estimates_[index(property)] = {std::nullopt, 0.0, "the world's answers give no number"};
  } else {
    estimates_[index(property)] = {value, uncertainty, ""};
  }
}

void Measurements::fail(Property property, std::string problem) {
  Measurement& estimate = estimates_[index(property)];
  if (!estimate.value && estimate.problem.empty()) {
    estimate.problem = std::move(problem);
  }
}

void Measurements::withdraw(Property property, std::string problem) {
  estimates_[index(property)] = {std::nullopt, 0.0, std::move(problem)};
}

double Measurements::need(Property property) const {
  const Measurement& estimate = (*this)[property];
  if (!estimate.value) {
    throw std::runtime_error(std::string("needs ") + describe(property).title + ": " + estimate.problem);
  }
  return *estimate.value;
}

}  // namespace sim2sim
