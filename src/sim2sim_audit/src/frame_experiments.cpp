// SPDX-License-Identifier: BSD-3-Clause
// Frames and units, found by touching the tee and by comparing velocities with finite differences.
#include <Eigen/Dense>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "pusht_task/constants.hpp"
#include "sim2sim_audit/experiments.hpp"

namespace sim2sim {
namespace {

using pusht::WorldState;

WorldState teeAt(const Bench& bench, double yaw) {
  WorldState scene;
  scene.tee_position = bench.shift();
  scene.tee_yaw = yaw;
  return scene;
}

/// [rad] Yaw that the stem has, for a yaw that the world was told: from the middle between its two sides.
double yawByTouch(Bench& bench, double yaw) {
  constexpr double kFree = 0.075;  // [m] beside the stem
  const WorldState scene = teeAt(bench, yaw);
  const Eigen::Vector2d middle = scene.tee_position - Eigen::Vector2d(0.0, pusht::kStemOffset);
  const auto right = touchDistance(bench, scene, middle, {1.0, 0.0}, 0.0, kFree);
  const auto left = touchDistance(bench, scene, middle, {-1.0, 0.0}, 0.0, kFree);
  if (!right || !left) {
    throw std::runtime_error("the stem is not where the yaw puts it");
  }
  return std::atan2(0.5 * (*right - *left), pusht::kStemOffset);
}

/// Unit, sense and zero of the yaw.
void yaw(Bench& bench, Measurements& found) {
  constexpr double kYaw = 0.15;  // [rad] so small that the stem is found even where the yaw has the other sense
  const double plus = yawByTouch(bench, kYaw);
  const double minus = yawByTouch(bench, -kYaw);
  found.set(Property::kYawGain, (plus - minus) / (2.0 * kYaw));
  found.set(Property::kYawOffset, 0.5 * (plus + minus));
}

/// Moment at which the tee turns and moves: pose, finite differences over the steps around, reported velocities.
struct Sample {
  double yaw;                ///< [rad]
  Eigen::Vector2d velocity;  ///< [m/s] by finite differences
  double yaw_rate;           ///< [rad/s] by finite differences
  Eigen::Vector2d reported;
  double reported_yaw_rate;
};

/// The tee while the pusher pushes it gently at the end of its bar, or straight on at the stem's end.
std::vector<Sample> pushedTee(Bench& bench) {
  struct Push {
    double yaw;            // [rad]
    Eigen::Vector2d from;  // [m] of the pusher, in the body frame
  };
  constexpr double kSpeed = 0.15;  // [m/s]
  constexpr int kSteps = 6;
  std::vector<Sample> samples;
  for (const Push& push : {Push{0.9, {0.045, -0.0305}}, Push{-2.1, {-0.045, -0.0305}}, Push{1.6, {0.0, -0.1205}}}) {
    WorldState start = teeAt(bench, push.yaw);
    const Eigen::Rotation2Dd turn(push.yaw);
    start.pusher_position = start.tee_position + turn * push.from;
    const auto states = bench.run(start, std::vector<Eigen::Vector2d>(kSteps, kSpeed * (turn * Eigen::Vector2d(0, 1))));
    for (std::size_t i = 2; i + 1 < states.size(); ++i) {
      const double span = 2.0 * pusht::kControlStep;
      samples.push_back({states[i].tee_yaw, (states[i + 1].tee_position - states[i - 1].tee_position) / span,
                         pusht::wrapAngle(states[i + 1].tee_yaw - states[i - 1].tee_yaw) / span,
                         states[i].tee_velocity, states[i].tee_yaw_rate});
    }
  }
  return samples;
}

/// Reading of the reported velocities: of which point, and how many times the finite differences.
struct Reading {
  double factor;
  double point;  ///< [m] from the tee origin along body -y
  double residual;
};

/// Least-squares reading. `in_body_axes`: the reported velocity is turned into the table frame first.
Reading readingOf(const std::vector<Sample>& samples, bool in_body_axes) {
  Eigen::MatrixXd columns(2 * static_cast<Eigen::Index>(samples.size()), 2);
  Eigen::VectorXd values(columns.rows());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& sample = samples[i];
    const Eigen::Index row = 2 * static_cast<Eigen::Index>(i);
    const Eigen::Rotation2Dd turn(in_body_axes ? sample.yaw : 0.0);
    columns.block<2, 1>(row, 0) = sample.velocity;
    columns.block<2, 1>(row, 1) = sample.yaw_rate * Eigen::Vector2d(std::cos(sample.yaw), std::sin(sample.yaw));
    values.segment<2>(row) = turn * sample.reported;
  }
  const Eigen::Vector2d solution = columns.colPivHouseholderQr().solve(values);
  return {solution[0], solution[1] / solution[0], (columns * solution - values).norm()};
}

void teeVelocities(Bench& bench, Measurements& found) {
  const std::vector<Sample> samples = pushedTee(bench);
  const Reading in_table = readingOf(samples, false);
  const Reading in_body = readingOf(samples, true);
  const bool table = in_table.residual <= in_body.residual;
  const Reading& reading = table ? in_table : in_body;
  double products = 0.0;
  double squares = 0.0;
  for (const Sample& sample : samples) {
    products += sample.reported_yaw_rate * sample.yaw_rate;
    squares += sample.yaw_rate * sample.yaw_rate;
  }
  if (squares < 1e-3) {
    throw std::runtime_error("the tee does not turn when it is pushed");
  }
  found.set(Property::kTeeVelocityFrame, table ? 0.0 : 1.0);
  found.set(Property::kTeeVelocityFactor, reading.factor);
  found.set(Property::kTeeVelocityPoint, reading.point);
  found.set(Property::kYawRateFactor, products / squares);
}

}  // namespace

std::vector<Experiment> frameExperiments() {
  return {{"yaw by touch", {Property::kYawGain, Property::kYawOffset}, yaw},
          {"velocities of the tee",
           {Property::kTeeVelocityFrame, Property::kTeeVelocityFactor, Property::kTeeVelocityPoint,
            Property::kYawRateFactor},
           teeVelocities}};
}

}  // namespace sim2sim
