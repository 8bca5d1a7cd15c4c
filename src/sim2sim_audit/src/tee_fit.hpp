// SPDX-License-Identifier: BSD-3-Clause
/// Numbers of a world's free tee, by a fit of the model to where its motions end.
#pragma once

#include <optional>

#include "sim2sim_audit/bench.hpp"
#include "tee_model.hpp"

namespace sim2sim {

/// Fit of a form of the model.
struct TeeFit {
  TeeNumbers numbers;
  TeeModelForm form;
  TeeNumbers::Vector errors;  ///< standard errors, in the units of the numbers
  double residual;            ///< [m] root mean square of what is left over
};

/// Best fit over the forms of the model, from `begin`. `disc`: whether Coulomb friction has one limit in every
/// direction. Where that is not known, the fit tells, and friction is smooth if that explains much more. Throws
/// std::runtime_error if no motion of the tee can be observed.
TeeFit fitFreeTee(Bench& bench, const TeeNumbers& begin, std::optional<bool> disc);

}  // namespace sim2sim
