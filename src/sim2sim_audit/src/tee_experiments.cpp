// SPDX-License-Identifier: BSD-3-Clause
// The tee alone on its table, and its mass by a push.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

#include "force_sensor.hpp"
#include "pusht_task/constants.hpp"
#include "sim2sim_audit/experiments.hpp"
#include "tee_model.hpp"

namespace sim2sim {
namespace {

using pusht::WorldState;

// Slides along the line of the tee's two centers do not turn it, and have a closed form.

/// Viscous and Coulomb friction per mass, from the momentum that slides at several speeds lose in a control step: loss
/// = damping * distance + friction * time, whatever the integrator, as long as the tee still slides.
struct SlideLaw {
  double damping;   ///< [1/s]
  double friction;  ///< [m/s^2]
};

/// Law of slides along `direction` (a unit vector in the table frame). None if no two slides stay on the table and
/// are still under way after a step.
std::optional<SlideLaw> slideLaw(Bench& bench, const Eigen::Vector2d& direction) {
  constexpr double kFrom = 0.28;      // [m] of the start behind the middle
  constexpr double kLongest = 0.59;   // [m] so that no corner reaches a wall
  constexpr double kSliding = 0.3;    // [m/s] below which friction may be at rest
  std::vector<Eigen::Vector3d> rows;  // distance [m], time [s], lost velocity [m/s]
  for (const double speed : {24.0, 21.0, 18.0, 5.0, 4.0, 3.0, 2.0, 1.7}) {
    WorldState start;
    start.tee_position = bench.shift() - kFrom * direction;
    start.tee_velocity = speed * direction;
    start.tee_yaw = pusht::wrapAngle(std::atan2(direction.y(), direction.x()) - 0.5 * pusht::kPi);
    start.pusher_position = 0.3 * Eigen::Vector2d(-direction.y(), direction.x());
    const auto states = bench.run(start, {{0.0, 0.0}});
    const double distance = (states[1].tee_position - states[0].tee_position).dot(direction);
    const double left = states[1].tee_velocity.dot(direction);
    if (distance < kLongest && left > kSliding) {
      rows.emplace_back(distance, pusht::kControlStep, speed - left);
    }
  }
  if (rows.size() < 2) {
    return std::nullopt;
  }
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(rows.size()), 2);
  Eigen::VectorXd losses(columns.rows());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    columns.row(static_cast<Eigen::Index>(i)) = rows[i].head<2>();
    losses[static_cast<Eigen::Index>(i)] = rows[i][2];
  }
  const Eigen::Vector2d law = columns.colPivHouseholderQr().solve(losses);
  return SlideLaw{law[0], law[1]};
}

/// [-] Coulomb friction askew over that along an axis; none where slides do not tell.
std::optional<double> shapeOf(const std::array<std::optional<SlideLaw>, 3>& slides) {
  if (!slides[0] || !slides[1] || !slides[2]) {
    return std::nullopt;
  }
  const double along_axes = 0.5 * (slides[0]->friction + slides[1]->friction);
  constexpr double kNone = 0.3;  // [m/s^2] a fortieth of the task's
  return along_axes > kNone ? std::optional(slides[2]->friction / along_axes) : std::nullopt;
}

// All other motions have none: a model is fitted to where they end.

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
  std::vector<WorldState> starts;
  for (const Motion& motion : motions) {
    WorldState start;
    start.tee_yaw = motion.yaw;
    start.tee_velocity = Eigen::Rotation2Dd(motion.yaw) * motion.velocity.head<2>();
    start.tee_yaw_rate = motion.velocity[2];
    start.tee_position = bench.shift() - 0.03 * start.tee_velocity;
    start.pusher_position = {0.36, 0.36};
    starts.push_back(start);
  }
  return starts;
}

/// What the world's tee does from these starts, as long as it stays clear of walls and pusher.
std::vector<Observed> observeFreeTee(Bench& bench) {
  constexpr int kSteps = 2;
  constexpr double kClear = 0.21;  // [m] from the middle: no corner reaches the walls
  std::vector<Observed> all;
  for (const WorldState& start : freeStarts(bench)) {
    if (getenv("SLOW") && std::abs(start.tee_yaw_rate) > atof(getenv("SLOW"))) continue;
    const auto states = bench.run(start, std::vector<Eigen::Vector2d>(kSteps, {0.0, 0.0}));
    Observed observed = {TeeMotion::of(states.front()), {}};
    for (std::size_t i = 1; i < states.size() && states[i].tee_position.norm() < kClear; ++i) {
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

/// Fit of a form of the model: numbers, their standard errors in units of TeeNumbers::scale(), and what is left over.
struct Fit {
  TeeNumbers numbers;
  TeeModelForm form;
  TeeNumbers::Vector errors;
  double residual;  ///< [m] root mean square
};

/// Fit by Levenberg and Marquardt from `begin`.
Fit fitFrom(const TeeNumbers& begin, const TeeModelForm& form, const std::vector<Observed>& all) {
  constexpr int kIterations = 40;
  constexpr double kStep = 1e-6;
  constexpr double kDone = 1e-10;  // relative
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
  const double freedom = std::max<double>(1.0, static_cast<double>(rest.size() - TeeNumbers::kCount));
  const Eigen::MatrixXd covariance =
      (jacobian.transpose() * jacobian + 1e-15 * Eigen::MatrixXd::Identity(TeeNumbers::kCount, TeeNumbers::kCount))
          .inverse() *
      (rest.squaredNorm() / freedom);
  return {TeeNumbers::fromVector(numbers), form, covariance.diagonal().cwiseAbs().cwiseSqrt(),
          std::sqrt(rest.squaredNorm() / static_cast<double>(rest.size()))};
}

/// Best fit over the forms of the model. `disc`: whether friction is known to have one limit in every direction.
Fit fitTee(const std::vector<Observed>& all, const TeeNumbers& begin, bool disc) {
  constexpr double kExact = 1e-6;  // [m] another form cannot be nearer
  Fit best = fitFrom(begin, {TeeIntegrator::kImplicitJoints, disc, 10}, all);
  const auto consider = [&](const TeeModelForm& form) {
    const Fit fit = fitFrom(form.substeps == best.form.substeps ? begin : best.numbers, form, all);
    const bool is_better = fit.residual < best.residual;
    best = is_better ? fit : best;
    return is_better;
  };
  for (const TeeIntegrator integrator : {TeeIntegrator::kJoints, TeeIntegrator::kBody}) {
    if (best.residual > kExact) {
      consider({integrator, disc, 10});
    }
  }
  // Engines take substeps of 10, 5, 2 or 1 ms.
  for (const int substeps : {20, 50, 100}) {
    if (best.residual < kExact || !consider({best.form.integrator, disc, substeps})) {
      break;
    }
  }
  return best;
}

/// [s] The tee's mass over the servo's gain: a straight push of which the pusher is the force sensor. The tee's
/// momentum takes it, and the frictions that slides have shown.
double massOverGain(Bench& bench, const Measurements& found, const SlideLaw& law) {
  constexpr double kCommand = 0.6;  // [m/s]
  const ForceSensor sensor(found);
  WorldState start;
  start.tee_position = bench.shift() - Eigen::Vector2d(0.0, 0.1);
  const double reach =
      found.need(Property::kStemEnd) - found.need(Property::kOriginY) + found.need(Property::kPusherRadius);
  start.pusher_position = start.tee_position + Eigen::Vector2d(found.need(Property::kOriginX), -reach);
  const Eigen::Vector2d command(0.0, kCommand);
  const auto states = bench.run(start, std::vector<Eigen::Vector2d>(3, command));
  double impulse = 0.0;  // [m] over the gain
  double taken = 0.0;    // [m/s] per mass
  // The first step, from rest, shows the momentum; the others, which slide all the time, the frictions.
  const std::size_t first = law.damping * kCommand + law.friction > 1.0 ? 1 : 0;
  for (std::size_t i = first; i + 1 < states.size(); ++i) {
    impulse += sensor.impulse(states[i], states[i + 1], command).y();
    taken += (states[i + 1].tee_velocity - states[i].tee_velocity).y() +
             law.damping * (states[i + 1].tee_position - states[i].tee_position).y() +
             law.friction * pusht::kControlStep;
  }
  if (taken < 0.1) {
    throw std::runtime_error("the push does not move the tee");
  }
  return impulse / taken;
}

/// [s m^2] The tee's moment of inertia about its center of mass, over the servo's gain: a push beside that center, of
/// which the pusher is the force sensor. The force goes through the pusher's center, as without friction.
/// `yaw_drag` [1/s]: yaw damping over moment, which free motions have shown.
double momentOverGain(Bench& bench, const Measurements& found, double center_of_mass, double yaw_drag) {
  constexpr int kSteps = 5;
  const ForceSensor sensor(found);
  WorldState start;
  start.tee_position = bench.shift();
  start.pusher_position = start.tee_position + Eigen::Vector2d(0.035, 0.04);  // behind the bar
  const Eigen::Vector2d command(0.0, -0.2);
  const auto states = bench.run(start, std::vector<Eigen::Vector2d>(kSteps, command));
  const auto arm = [&](const WorldState& state) -> Eigen::Vector2d {
    const Eigen::Vector2d down(std::sin(state.tee_yaw), -std::cos(state.tee_yaw));
    return state.pusher_position - (state.tee_position + center_of_mass * down);
  };
  double torque = 0.0;  // [m^2] over the gain, times time
  double taken = 0.0;   // [rad/s]
  for (std::size_t i = 0; i + 1 < states.size(); ++i) {
    const Eigen::Vector2d impulse = sensor.impulse(states[i], states[i + 1], command);
    const Eigen::Vector2d middle = 0.5 * (arm(states[i]) + arm(states[i + 1]));
    torque += middle.x() * impulse.y() - middle.y() * impulse.x();
    taken += states[i + 1].tee_yaw_rate - states[i].tee_yaw_rate +
             yaw_drag * pusht::wrapAngle(states[i + 1].tee_yaw - states[i].tee_yaw);
  }
  constexpr double kLeast = 0.1;  // [rad/s]
  if (std::abs(taken) < kLeast) {
    throw std::runtime_error("the push does not turn the tee");
  }
  return torque / taken;
}

/// Frictions along x, y and askew: by slides, or where these do not tell, by the fit.
struct Frictions {
  SlideLaw along_x;
  SlideLaw along_y;
  double shape;  ///< [-] Coulomb friction askew over that along an axis
};

Frictions frictionsOf(const std::array<std::optional<SlideLaw>, 3>& slides, const Fit& fit) {
  const TeeNumbers& numbers = fit.numbers;
  return {slides[0].value_or(SlideLaw{numbers.damping, numbers.friction_x}),
          slides[1].value_or(SlideLaw{numbers.damping, numbers.friction_y}),
          shapeOf(slides).value_or(fit.form.disc_friction ? 1.0 : std::sqrt(2.0))};
}

void freeTee(Bench& bench, Measurements& found) {
  const std::array<std::optional<SlideLaw>, 3> slides = {slideLaw(bench, {1.0, 0.0}), slideLaw(bench, {0.0, 1.0}),
                                                         slideLaw(bench, {std::sqrt(0.5), std::sqrt(0.5)})};
  TeeNumbers begin = TeeNumbers::ofTask();
  if (slides[0] && slides[1]) {
    begin.damping = 0.5 * (slides[0]->damping + slides[1]->damping);
    begin.friction_x = std::max(0.0, slides[0]->friction);
    begin.friction_y = std::max(0.0, slides[1]->friction);
  }
  constexpr double kBetweenDiscAndBox = 1.2;  // [-]
  const bool disc = shapeOf(slides).value_or(std::sqrt(2.0)) < kBetweenDiscAndBox;
  const Fit fit = fitTee(observeFreeTee(bench), begin, disc);
  constexpr double kSigmas = 3.0;
  const TeeNumbers::Vector errors = kSigmas * fit.errors.cwiseProduct(TeeNumbers::scale());
  const Frictions frictions = frictionsOf(slides, fit);
  const double damping = 0.5 * (frictions.along_x.damping + frictions.along_y.damping);
  constexpr double kNone = 0.3;  // [m/s^2] and [1/s] below which a force is none: a thirtieth of the task's
  const bool has_friction = frictions.along_x.friction + frictions.along_y.friction > 2.0 * kNone;
  found.set(Property::kCenterOfMass, fit.numbers.center_of_mass, errors[0]);
  if (has_friction) {
    found.set(Property::kFrictionShape, frictions.shape);
    found.set(Property::kFrictionPoint, fit.numbers.friction_point, errors[8]);
  } else {
    found.fail(Property::kFrictionShape, "there is no Coulomb friction");
    found.fail(Property::kFrictionPoint, "there is no Coulomb friction");
  }
  if (damping > kNone) {
    found.set(Property::kDampingPoint, fit.numbers.damping_point, errors[7]);
  } else {
    found.fail(Property::kDampingPoint, "there is no damping");
  }
  const double mass = massOverGain(bench, found, frictions.along_y);
  found.set(Property::kTeeMass, mass);
  found.set(Property::kTeeDamping, damping * mass);
  found.set(Property::kTeeFrictionX, frictions.along_x.friction * mass);
  found.set(Property::kTeeFrictionY, frictions.along_y.friction * mass);
  const double yaw_drag = fit.numbers.yaw_damping / fit.numbers.moment;  // [1/s]
  constexpr double kUnknown =
      0.3;  // [-] error of a moment of which free motions say nothing: nothing else turns the tee
  if (errors[1] < kUnknown * fit.numbers.moment) {
    found.set(Property::kTeeMoment, fit.numbers.moment * mass, errors[1] * mass);
    found.set(Property::kTeeYawDamping, fit.numbers.yaw_damping * mass, errors[3] * mass);
    found.set(Property::kTeeYawFriction, fit.numbers.yaw_friction * mass, errors[6] * mass);
  } else {
    const double moment = momentOverGain(bench, found, fit.numbers.center_of_mass, yaw_drag);
    found.set(Property::kTeeMoment, moment);
    found.set(Property::kTeeYawDamping, yaw_drag * moment);
    found.set(Property::kTeeYawFriction, fit.numbers.yaw_friction / fit.numbers.moment * moment);
  }
}

}  // namespace

std::vector<Experiment> teeExperiments() {
  return {{"free tee",
           {Property::kTeeMass, Property::kCenterOfMass, Property::kTeeMoment, Property::kTeeDamping,
            Property::kTeeYawDamping, Property::kTeeFrictionX, Property::kTeeFrictionY, Property::kTeeYawFriction,
            Property::kFrictionShape, Property::kDampingPoint, Property::kFrictionPoint},
           freeTee}};
}

}  // namespace sim2sim
