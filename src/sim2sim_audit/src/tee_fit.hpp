// SPDX-License-Identifier: BSD-3-Clause
/// Numbers of a world's free tee, by a fit of the model to where its motions end.
#pragma once

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
/// direction. Throws std::runtime_error if no motion of the tee can be observed.
TeeFit fitFreeTee(Bench& bench, const TeeNumbers& begin, bool disc);

}  // namespace sim2sim
