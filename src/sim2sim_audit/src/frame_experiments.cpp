// SPDX-License-Identifier: BSD-3-Clause
// Frames and units, found by touching the tee and by comparing velocities with finite differences.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "experiments.hpp"
#include "pusht_task/constants.hpp"

namespace sim2sim {
namespace {

using pusht::WorldState;

WorldState teeAt(const Bench& bench, double yaw) {
  WorldState scene;
  scene.tee_position = bench.shift();
  scene.tee_yaw = yaw;
  return scene;
}

/// Whether the pusher at `outward` times a distance [m] from the tee touches it.
using IsTouched = std::function<bool(const Eigen::Vector2d& outward, double distance)>;

/// Sum of the directions, by twelfths of a turn, in which the stem is: on this circle about the tee origin the pusher
/// touches nothing else.
Eigen::Vector2d touchedDirections(const IsTouched& is_touched) {
  constexpr double kCircle = 0.09;  // [m]
  constexpr int kDirections = 24;
  Eigen::Vector2d touched = Eigen::Vector2d::Zero();
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2.0 * pusht::kPi * i / kDirections;
    const Eigen::Vector2d outward(std::cos(angle), std::sin(angle));
    touched += is_touched(outward, kCircle) ? outward : Eigen::Vector2d::Zero();
  }
  return touched;
}

/// [rad] Direction of the stem, to a twelfth of a turn: where the pusher is pushed away; in a world that leaves
/// overlaps alone, where it is held beside it.
double stemByTouch(Bench& bench, const WorldState& scene) {
  constexpr double kFree = 0.2;   // [m]
  constexpr double kLeast = 0.5;  // of a direction
  const auto at = [&](const Eigen::Vector2d& outward, double distance) {
    WorldState state = scene;
    state.pusher_position = scene.tee_position + distance * outward;
    return state;
  };
  Eigen::Vector2d touched = touchedDirections(
      [&](const Eigen::Vector2d& outward, double distance) { return bench.isPushedApart(at(outward, distance)); });
  if (touched.norm() < kLeast) {
    touched = touchedDirections([&](const Eigen::Vector2d& outward, double distance) {
      const Eigen::Vector2d beside(-outward.y(), outward.x());
      const auto is_held = [&](const Eigen::Vector2d& direction) {
        return bench.isHeld(at(outward, distance), direction, bench.slowWay(at(outward, kFree), direction));
      };
      return is_held(beside) || is_held(-beside);
    });
  }
  if (touched.norm() < kLeast) {
    throw std::runtime_error("the tee has no stem");
  }
  return std::atan2(touched.y(), touched.x()) + 0.5 * pusht::kPi;  // of a yaw at which the stem is there
}

/// [rad] Yaw that the tee has, for a yaw that the world was told: which way the stem goes, and how steep the back of
/// the bar is; of a bar with a round back, where the middles of stem and bar are. Where the tee origin is does not
/// matter.
double yawByTouch(Bench& bench, double yaw) {
  constexpr double kAside = 0.04;  // [m] along the bar, on either side
  constexpr double kDown = pusht::kStemOffset;
  constexpr double kInside = 1e-3;  // [m]
  constexpr double kFree = 0.1;
  const WorldState scene = teeAt(bench, yaw);
  const Eigen::Rotation2Dd turn(stemByTouch(bench, scene));
  const auto surface = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& outward) {
    const auto distance =
        touchDistance(bench, {scene, scene.tee_position + turn * from, turn * outward, kInside, kFree});
    if (!distance) {
      throw std::runtime_error("the bar is not where the stem says");
    }
    return *distance;
  };
  const auto back = [&](double along) { return surface({along, 0.0}, {0.0, 1.0}); };
  const auto middle = [&](double down) {
    return 0.5 * (surface({0.0, -down}, {1.0, 0.0}) - surface({0.0, -down}, {-1.0, 0.0}));
  };
  const double right = back(kAside);
  const double left = back(-kAside);
  constexpr double kRound = 3e-3;  // [m]
  const double more = back(0.0) - 0.5 * (right + left) > kRound ? std::atan2(middle(kDown) - middle(0.0), kDown)
                                                                : std::atan2(right - left, 2.0 * kAside);
  return pusht::wrapAngle(turn.angle() + more);
}

/// Unit, sense and zero of the yaw.
void yaw(Bench& bench, Measurements& found) {
  constexpr double kYaw = 0.15;  // [rad]
  found.set(Property::kYawOffset, yawByTouch(bench, 0.0));
  found.set(Property::kYawGain, pusht::wrapAngle(yawByTouch(bench, kYaw) - yawByTouch(bench, -kYaw)) / (2.0 * kYaw));
}

/// Two control steps of a tee that moves: what it moved by, and what it should have by the velocities reported at their
/// begin, middle and end (Simpson's rule).
struct Sample {
  Eigen::Vector2d displacement;   ///< [m]
  double turn;                    ///< [rad]
  Eigen::Vector2d turn_of_point;  ///< [-] displacement of a point on body -y against the origin, per distance from it
  Eigen::Vector2d by_velocity;    ///< [m] velocities read in the table's axes
  Eigen::Vector2d by_body_velocity;  ///< [m] velocities read in the tee's axes
  double by_yaw_rate;                ///< [rad]
};

Eigen::Vector2d bodyDown(double yaw) { return {std::sin(yaw), -std::cos(yaw)}; }

Sample sampleOf(const WorldState& begin, const WorldState& middle, const WorldState& end) {
  Sample sample = {end.tee_position - begin.tee_position,
                   pusht::wrapAngle(end.tee_yaw - middle.tee_yaw) + pusht::wrapAngle(middle.tee_yaw - begin.tee_yaw),
                   bodyDown(end.tee_yaw) - bodyDown(begin.tee_yaw),
                   Eigen::Vector2d::Zero(),
                   Eigen::Vector2d::Zero(),
                   0.0};
  const auto add = [&](const WorldState& state, double weight) {
    const double span = weight * pusht::kControlStep / 3.0;
    sample.by_velocity += span * state.tee_velocity;
    sample.by_body_velocity += span * (Eigen::Rotation2Dd(state.tee_yaw) * state.tee_velocity);
    sample.by_yaw_rate += span * state.tee_yaw_rate;
  };
  add(begin, 1.0);
  add(middle, 4.0);
  add(end, 1.0);
  return sample;
}

/// [-] How much the motion of two control steps changes between them. The poses alone say so.
double changeIn(const WorldState& begin, const WorldState& middle, const WorldState& end) {
  const auto moved = [](const WorldState& from, const WorldState& to) {
    const Eigen::Vector2d way = to.tee_position - from.tee_position;
    return Eigen::Vector3d(way.x(), way.y(), pusht::kStemOffset * pusht::wrapAngle(to.tee_yaw - from.tee_yaw));
  };
  const Eigen::Vector3d first = moved(begin, middle);
  return (moved(middle, end) - first).norm() / first.norm();
}

/// The steadiest of the samples of a push: in the others contacts begin, end or chatter, of which velocities at three
/// moments say little.
std::vector<Sample> steadiest(const std::vector<WorldState>& states) {
  constexpr std::size_t kSamples = 3;
  std::vector<std::pair<double, std::size_t>> by_change;
  for (std::size_t i = 1; i + 2 < states.size(); ++i) {
    if (const double change = changeIn(states[i], states[i + 1], states[i + 2]); std::isfinite(change)) {
      by_change.emplace_back(change, i);
    }
  }
  std::sort(by_change.begin(), by_change.end());
  std::vector<Sample> samples;
  for (std::size_t rank = 0; rank < std::min(kSamples, by_change.size()); ++rank) {
    const std::size_t i = by_change[rank].second;
    samples.push_back(sampleOf(states[i], states[i + 1], states[i + 2]));
  }
  return samples;
}

/// The tee while the pusher pushes it gently beside the middle of its bar, or straight on at the stem's end.
std::vector<Sample> pushedTee(Bench& bench) {
  struct Push {
    double yaw;                 // [rad]
    Eigen::Vector2d from;       // [m] of the pusher, in the body frame
    Eigen::Vector2d direction;  // in the body frame
  };
  constexpr double kWay = 0.12;  // [m] that the pusher takes
  const Eigen::Vector2d up(0.0, 1.0);
  std::vector<Sample> samples;
  for (const Push& push :
       {Push{0.9, {0.035, 0.0335}, -up}, Push{-2.1, {-0.035, 0.0335}, -up}, Push{1.6, {0.0, -0.1205}, up}}) {
    for (const double speed : {0.1, 0.15, 0.2}) {  // [m/s]
      WorldState start = teeAt(bench, push.yaw);
      const Eigen::Rotation2Dd turn(push.yaw);
      start.pusher_position = start.tee_position + turn * push.from;
      const auto steps = static_cast<std::size_t>(kWay / (speed * pusht::kControlStep));
      const std::vector<Sample> of_push =
          steadiest(bench.run(start, std::vector<Eigen::Vector2d>(steps, speed * (turn * push.direction))));
      samples.insert(samples.end(), of_push.begin(), of_push.end());
    }
  }
  return samples;
}

/// Least-squares solution with standard errors from what is left over.
struct Solution {
  Eigen::VectorXd values;
  Eigen::VectorXd errors;
  double residual;
  double size;  ///< of what was wanted
};

Solution solve(const Eigen::MatrixXd& columns, const Eigen::VectorXd& wanted) {
  const Eigen::VectorXd values = columns.colPivHouseholderQr().solve(wanted);
  const double residual = (columns * values - wanted).norm();
  const double variance = residual * residual / static_cast<double>(columns.rows() - columns.cols());
  const Eigen::MatrixXd inverse = (columns.transpose() * columns).inverse();
  return {values, (variance * inverse.diagonal()).cwiseSqrt(), residual, wanted.norm()};
}

/// Factor of the reported velocities, and factor times the distance of their point from the tee origin along body -y
/// [m]. `in_body_axes`: the reported velocities are taken to be in the tee's axes.
Solution readingOf(const std::vector<Sample>& samples, bool in_body_axes) {
  Eigen::MatrixXd columns(2 * static_cast<Eigen::Index>(samples.size()), 2);
  Eigen::VectorXd values(columns.rows());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& sample = samples[i];
    const Eigen::Index row = 2 * static_cast<Eigen::Index>(i);
    columns.block<2, 1>(row, 0) = sample.displacement;
    columns.block<2, 1>(row, 1) = sample.turn_of_point;
    values.segment<2>(row) = in_body_axes ? sample.by_body_velocity : sample.by_velocity;
  }
  return solve(columns, values);
}

/// [-] What is left of the reported velocities if they may be any linear map of the true ones.
double leftOfAnyMap(const std::vector<Sample>& samples) {
  const auto count = static_cast<Eigen::Index>(samples.size());
  Eigen::MatrixXd columns(count, 4);
  Eigen::MatrixXd values(count, 2);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    columns.row(row) << samples[i].displacement.transpose(), samples[i].turn_of_point.transpose();
    values.row(row) = samples[i].by_velocity.transpose();
  }
  return (columns * columns.colPivHouseholderQr().solve(values) - values).norm() / values.norm();
}

/// Factor of the reported yaw rates.
Solution yawRateOf(const std::vector<Sample>& samples) {
  Eigen::MatrixXd turns(static_cast<Eigen::Index>(samples.size()), 1);
  Eigen::VectorXd by_rate(turns.rows());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    turns(static_cast<Eigen::Index>(i), 0) = samples[i].turn;
    by_rate[static_cast<Eigen::Index>(i)] = samples[i].by_yaw_rate;
  }
  constexpr double kLeast = 1e-2;  // [rad]
  if (turns.norm() < kLeast) {
    throw std::runtime_error("the tee does not turn when it is pushed");
  }
  return solve(turns, by_rate);
}

/// Three standard errors, but not so many that a reading which fits nothing is the same as all.
double uncertaintyOf(double standard_error, double most) { return std::min(3.0 * standard_error, most); }

void teeVelocities(Bench& bench, Measurements& found) {
  constexpr double kOfFactor = 0.1;  // [-]
  constexpr double kOfPoint = 5e-3;  // [m]
  const std::vector<Sample> samples = pushedTee(bench);
  const Solution yaw_rate = yawRateOf(samples);
  const Solution in_table = readingOf(samples, false);
  const Solution in_body = readingOf(samples, true);
  const bool table = in_table.residual <= in_body.residual;
  const Solution& reading = table ? in_table : in_body;
  constexpr double kFits = 0.15;  // [-]
  if (reading.residual > kFits * reading.size) {
    if (leftOfAnyMap(samples) > kFits) {
      throw std::runtime_error("reported velocities do not fit the motion in any axes");
    }
    found.set(Property::kTeeVelocityFrame, 2.0);
    return;
  }
  const double factor = reading.values[0];
  found.set(Property::kTeeVelocityFrame, table ? 0.0 : 1.0);
  found.set(Property::kTeeVelocityFactor, factor, uncertaintyOf(reading.errors[0], kOfFactor));
  found.set(Property::kYawRateFactor, yaw_rate.values[0], uncertaintyOf(yaw_rate.errors[0], kOfFactor));
  const double point = reading.values[1] / factor;
  const double error = reading.errors[1] / std::abs(factor);
  if (std::abs(point) > kOfPoint && std::abs(point) <= 3.0 * error) {
    throw std::runtime_error("reported velocities fit a point of the tee to within some millimeters only");
  }
  found.set(Property::kTeeVelocityPoint, point, uncertaintyOf(error, kOfPoint));
}

}  // namespace

std::vector<Experiment> frameExperiments() {
  return {{"yaw by touch", {Property::kYawGain, Property::kYawOffset}, yaw},
          {"velocities of the tee",
           {Property::kTeeVelocityFrame, Property::kTeeVelocityFactor, Property::kTeeVelocityPoint,
            Property::kYawRateFactor},
           teeVelocities,
           true}};
}

}  // namespace sim2sim
