// SPDX-License-Identifier: BSD-3-Clause
#include "tee_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "pusht_task/constants.hpp"

namespace sim2sim {
namespace {

using pusht::WorldState;

/// Motion of a free tee: its start, and its poses after each control step.
struct Observed {
  TeeMotion start;
  std::vector<Eigen::Vector3d> poses;
};

/// Starts at which the tee slides along, across and askew, turns about its origin, about another point, and both.
std::vector<WorldState> freeStarts(const Bench& bench) {
  struct Motion {
    double yaw;
    Eigen::Vector3d velocity;  // in the body frame [m/s, m/s, rad/s]
  };
  const std::array<Motion, 14> motions = {{{0.0, {0.0, 1.0, 0.0}},
                                           {0.5 * pusht::kPi, {0.0, 3.0, 0.0}},
                                           {0.0, {0.6, 0.0, 0.0}},
                                           {0.7, {1.0, 0.0, 0.0}},
                                           {-2.0, {-3.0, 0.0, 0.0}},
                                           {0.0, {0.0, 0.0, 1.0}},
                                           {0.4, {0.0, 0.0, -3.0}},
                                           {-1.0, {0.0, 0.0, 5.0}},
                                           {1.0, {-0.1, 0.0, 4.0}},
                                           {-0.5, {0.3, 0.0, -5.0}},
                                           {-2.6, {2.0, 1.0, 3.0}},
                                           {0.8, {-1.0, 2.0, -5.0}},
                                           {-1.4, {4.0, -3.0, 4.0}},
                                           {0.2, {0.2, 0.2, 1.0}}}};
  const double shorter = 1.0 - bench.narrower() / 0.28;  // [-] ways, between nearer walls
  std::vector<WorldState> starts;
  for (const Motion& motion : motions) {
    WorldState start;
    start.tee_yaw = motion.yaw;
    start.tee_velocity = shorter * (Eigen::Rotation2Dd(motion.yaw) * motion.velocity.head<2>());
    start.tee_yaw_rate = motion.velocity[2];
    start.tee_position = bench.shift() - 0.03 * start.tee_velocity;
    start.pusher_position = Eigen::Vector2d::Constant(0.36 - bench.narrower());
    starts.push_back(start);
  }
  return starts;
}

/// What the world's tee does from these starts, as long as it stays clear of walls and pusher.
std::vector<Observed> observeFreeTee(Bench& bench) {
  constexpr int kSteps = 2;
  const double clear = 0.21 - bench.narrower();  // [m] from the middle: no corner reaches the walls
  std::vector<Observed> all;
  for (const WorldState& start : freeStarts(bench)) {
    const auto states = bench.run(start, std::vector<Eigen::Vector2d>(kSteps, {0.0, 0.0}));
    Observed observed = {TeeMotion::of(states.front()), {}};
    for (std::size_t i = 1; i < states.size() && states[i].tee_position.norm() < clear; ++i) {
      observed.poses.push_back(TeeMotion::of(states[i]).pose);
    }
    if (!observed.poses.empty()) {
      all.push_back(observed);
    }
  }
  return all;
}

/// [m] Differences of model and world, yaws at the tee's size.
Eigen::VectorXd differences(const TeeNumbers& numbers, const TeeModelForm& form, const std::vector<Observed>& all) {
  std::vector<double> result;
  for (const Observed& observed : all) {
    TeeMotion motion = observed.start;
    for (const Eigen::Vector3d& pose : observed.poses) {
      motion = controlStep(numbers, form, motion);
      result.push_back(motion.pose[0] - pose[0]);
      result.push_back(motion.pose[1] - pose[1]);
      result.push_back(pusht::kStemOffset * pusht::wrapAngle(motion.pose[2] - pose[2]));
    }
  }
  return Eigen::Map<const Eigen::VectorXd>(result.data(), static_cast<Eigen::Index>(result.size()));
}

/// Fit by Levenberg and Marquardt from `begin`.
TeeFit fitFrom(const TeeNumbers& begin, const TeeModelForm& form, const std::vector<Observed>& all) {
  constexpr int kIterations = 40;
  constexpr double kStep = 1e-6;
  constexpr double kDone = 1e-10;    // relative
  constexpr double kSteepest = 0.2;  // [-] least smoothing that substeps of 1 ms can follow
  using Vector = TeeNumbers::Vector;
  Vector numbers = begin.toVector();
  Eigen::VectorXd rest = differences(begin, form, all);
  Eigen::MatrixXd jacobian(rest.size(), TeeNumbers::kCount);
  double damping = 1e-3;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    for (Eigen::Index i = 0; i < TeeNumbers::kCount; ++i) {
      Vector moved = numbers;
      moved[i] += kStep;
      jacobian.col(i) = (differences(TeeNumbers::fromVector(moved), form, all) - rest) / kStep;
    }
    const Eigen::Matrix<double, TeeNumbers::kCount, TeeNumbers::kCount> normal = jacobian.transpose() * jacobian;
    const Vector gradient = jacobian.transpose() * rest;
    bool better = false;
    double gained = 0.0;
    for (int attempt = 0; attempt < 8 && !better; ++attempt) {
      auto damped = normal;
      damped.diagonal() *= 1.0 + damping;
      damped.diagonal().array() += 1e-15;
      Vector candidate = numbers - damped.ldlt().solve(gradient);
      candidate[1] = std::max(candidate[1], 0.01);                      // a moment is above 0
      candidate.segment<3>(4) = candidate.segment<3>(4).cwiseMax(0.0);  // frictions, whose slope at 0 is that above it
      candidate.tail<2>() = candidate.tail<2>().cwiseMax(kSteepest);
      const Eigen::VectorXd candidate_rest = differences(TeeNumbers::fromVector(candidate), form, all);
      better = candidate_rest.squaredNorm() < rest.squaredNorm();
      if (better) {
        gained = 1.0 - candidate_rest.squaredNorm() / rest.squaredNorm();
        numbers = candidate;
        rest = candidate_rest;
      }
      damping *= better ? 0.2 : 5.0;
    }
    if (!better || gained < kDone) {
      break;
    }
  }
  constexpr double kSmallestError = 1e-6;  // [m] an exact fit of numbers that no motion tells apart is none
  const double freedom = std::max<double>(1.0, static_cast<double>(rest.size() - TeeNumbers::kCount));
  const Eigen::MatrixXd covariance =
      (jacobian.transpose() * jacobian + 1e-15 * Eigen::MatrixXd::Identity(TeeNumbers::kCount, TeeNumbers::kCount))
          .inverse() *
      std::max(rest.squaredNorm() / freedom, kSmallestError * kSmallestError);
  return {TeeNumbers::fromVector(numbers), form,
          covariance.diagonal().cwiseAbs().cwiseSqrt().cwiseProduct(TeeNumbers::scale()),
          std::sqrt(rest.squaredNorm() / static_cast<double>(rest.size()))};
}

constexpr double kExact = 1e-6;  // [m] residual of a fit to which another form cannot be nearer

/// Better of two fits.
const TeeFit& better(const TeeFit& a, const TeeFit& b) { return b.residual < a.residual ? b : a; }

/// Best fit over integrators.
TeeFit fitOverIntegrators(TeeModelForm form, const TeeNumbers& begin, const std::vector<Observed>& all) {
  TeeFit best = fitFrom(begin, form, all);
  for (const TeeIntegrator integrator : {TeeIntegrator::kJoints, TeeIntegrator::kBody}) {
    form.integrator = integrator;
    best = best.residual > kExact ? better(best, fitFrom(begin, form, all)) : best;
  }
  return best;
}

/// Better of a fit and one in which bodies move first.
TeeFit fitOverOrders(const TeeFit& best, const TeeNumbers& begin, const std::vector<Observed>& all) {
  TeeModelForm form = best.form;
  form.integrator = TeeIntegrator::kBody;
  form.moves_first = true;
  return best.residual > kExact ? better(best, fitFrom(begin, form, all)) : best;
}

/// Fit with the shorter of `substeps` that are better, one after the other.
TeeFit refined(TeeFit best, const std::vector<int>& substeps, const std::vector<Observed>& all) {
  for (const int count : substeps) {
    TeeModelForm form = best.form;
    form.substeps = count;
    const TeeFit fit = best.residual > kExact ? fitFrom(best.numbers, form, all) : best;
    if (!(fit.residual < best.residual)) {
      break;
    }
    best = fit;
  }
  return best;
}

/// Whether friction has one limit in every direction: that explains much more than a limit along each axis.
TeeFit boxOrDisc(const TeeFit& box, const TeeNumbers& begin, const std::vector<Observed>& all) {
  constexpr double kMuchLess = 0.5;  // [-]
  TeeModelForm form;
  form.disc_friction = true;
  const TeeFit disc = box.residual > kExact ? fitOverIntegrators(form, begin, all) : box;
  return disc.residual < kMuchLess * box.residual ? disc : box;
}

/// Smooth friction, if that explains much more than `sharp`.
TeeFit sharpOrSmooth(const TeeFit& sharp, const TeeNumbers& begin, const std::vector<Observed>& all) {
  constexpr double kPoor = 6e-5;      // [m]
  constexpr double kMuchLess = 0.25;  // [-]
  if (sharp.residual < kPoor) {
    return sharp;
  }
  TeeModelForm form;
  form.disc_friction = sharp.form.disc_friction;
  form.smooth_friction = true;
  form.substeps = 100;
  const TeeFit smooth = refined(fitOverIntegrators(form, begin, all), {200}, all);
  return smooth.residual < kMuchLess * sharp.residual ? smooth : sharp;
}

}  // namespace

TeeFit fitFreeTee(Bench& bench, const TeeNumbers& begin, std::optional<bool> disc) {
  const std::vector<Observed> all = observeFreeTee(bench);
  if (all.empty()) {
    throw std::runtime_error("a free tee does not stay on the table");
  }
  TeeModelForm form;
  form.disc_friction = disc.value_or(false);
  if (bench.physics().table_point != 0.0) {
    form.integrator = TeeIntegrator::kBody;  // no coordinates are of the tee origin
  }
  const bool is_of_body = form.integrator == TeeIntegrator::kBody;
  const TeeFit over_integrators = fitOverIntegrators(form, begin, all);
  const TeeFit first = is_of_body ? fitOverOrders(over_integrators, begin, all) : over_integrators;
  // Engines take substeps of 10, 5, 2, 1 or 0.5 ms.
  const TeeFit sharp = refined(disc ? first : boxOrDisc(first, begin, all), {20, 50, 100, 200}, all);
  return disc ? sharp : sharpOrSmooth(sharp, begin, all);
}

}  // namespace sim2sim
