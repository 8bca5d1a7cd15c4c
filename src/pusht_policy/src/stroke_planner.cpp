// SPDX-License-Identifier: BSD-3-Clause
#include "stroke_planner.hpp"

#include <algorithm>
#include <array>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <cstddef>
#include <utility>

#include "pusht_task/constants.hpp"
#include "pusht_task/task.hpp"

namespace pusht {
namespace {

using Eigen::Vector2d;

// Costs. From the target, 0.95 of it is left covered after 2.6 mm along an axis of the tee or 0.042 rad.
constexpr double kArmOfYaw = 0.06;         // [m] at which an error of yaw counts as one of position
constexpr double kSmallestError = 0.0005;  // [m] below which nothing is gained
constexpr double kPriceOfStep = 0.02;      // of a control step, in units of the error's logarithm
constexpr double kPriceOfBump = 0.5;       // of an approach that moves the tee, likewise
constexpr double kBumpDistance = 0.0002;   // [m] that a tee may move while the pusher goes to where a stroke begins

// Strokes.
constexpr double kRoom = 0.005;      // [m] between pusher and tee, on the way and where a stroke begins
constexpr double kRoomStep = 0.002;  // [m] to go back for it
constexpr int kMostRoomSteps = 20;
constexpr double kWallMargin = 0.001;   // [m] between pusher and walls
constexpr double kPushStep = 0.02;      // [m] per control step, of the reference in a stroke
constexpr double kMostTravel = 0.15;    // [m] of a probe
constexpr double kLeastTravel = 0.004;  // [m] of a refined stroke
constexpr int kMostProbeSteps = 12;     // control steps
constexpr int kMostSettlingSteps = 6;   // control steps at the end of an approach
constexpr double kSettled = 0.004;      // [m] from there, where a stroke may begin
constexpr int kFinalSteps = 4;          // control steps at the end of a stroke, until the pusher is there
constexpr double kVelocityGain = 5.0;   // [1/s] by which a drive to velocities goes to a position
constexpr std::array kApproachSteps = {0.05, 0.03, 0.015};  // [m] per control step, of the reference

// Time of an approach before it is planned, for probes.
constexpr double kTypicalApproachStep = 0.04;  // [m] per control step
constexpr int kTypicalDelay = 6;               // control steps of starting, stopping and going around

// Search.
constexpr int kPoints = 32;                            // around the tee
constexpr std::array kAngles = {-0.6, 0.0, 0.6};       // [rad]
constexpr int kParts = 4;                              // of a control step, at whose ends a probe is judged
constexpr int kTrials = 3;                             // of the best probes
constexpr int kRefinements = 40;                       // random strokes
constexpr double kShareSpread = 0.012;                 // standard deviations of a refinement, at first
constexpr double kAngleSpread = 0.15;                  // [rad]
constexpr double kTravelSpread = 0.008;                // [m]
constexpr double kNarrowing = 0.95;                    // of the spread after a refinement in vain
constexpr double kLeastSpread = 0.1;                   // of the first one
constexpr double kWorthwhile = 0.9;                    // of the error: a stroke that leaves more is not
constexpr int kLookaheadPoints = 16;                   // around the tee
constexpr std::array kStraight = {0.0};                // [rad] of second strokes
constexpr std::array kLookaheadAngles = {-0.4, 0.4};   // [rad]
constexpr std::array kLookaheadTravels = {0.05, 0.1};  // [m]
constexpr double kLeastMotion = 0.01;                  // [m] of the tee, by a first of two strokes

Eigen::Isometry2d placementOfTee(const WorldState& state) {
  return Eigen::Translation2d(state.tee_position) * Eigen::Rotation2Dd(state.tee_yaw);
}

/// [m] How far apart the tees of two states are, by a point of them and the yaw.
double distanceOfTees(const WorldState& one, const WorldState& other, double point) {
  const Vector2d arm(0.0, -point);
  const double way = (placementOfTee(one) * arm - placementOfTee(other) * arm).norm();
  return std::hypot(way, kArmOfYaw * wrapAngle(one.tee_yaw - other.tee_yaw));
}

/// State whose poses are a share of the way from one to another.
WorldState between(const WorldState& one, const WorldState& other, double share) {
  WorldState state = one;
  state.pusher_position += share * (other.pusher_position - one.pusher_position);
  state.tee_position += share * (other.tee_position - one.tee_position);
  state.tee_yaw = wrapAngle(one.tee_yaw + share * wrapAngle(other.tee_yaw - one.tee_yaw));
  return state;
}

/// Points at equal distances of `step` [m] along a way through corners, and its end.
std::vector<Vector2d> pointsAlong(const std::vector<Vector2d>& corners, double step) {
  std::vector<Vector2d> points;
  Vector2d here = corners.front();
  double left = step;
  for (std::size_t next = 1; next < corners.size();) {
    const Vector2d way = corners[next] - here;
    if (way.norm() <= left) {
      left -= way.norm();
      here = corners[next++];
    } else {
      here += left / way.norm() * way;
      points.push_back(here);
      left = step;
    }
  }
  points.push_back(here);
  return points;
}

template <class Costed>
bool isCheaper(const Costed& one, const std::optional<Costed>& other) {
  return !other || one.cost < other->cost;
}

}  // namespace

Action actionToward(const Vector2d& reference, const Vector2d& position, const Task& task) {
  const Physics& physics = task.physics;
  const double gain =
      physics.drive == Drive::kPosition ? physics.servo_stiffness / physics.servo_gain : kVelocityGain;  // [1/s]
  return actionFor(gain * (reference - position), position, task);
}

StrokePlanner::StrokePlanner(std::unique_ptr<Simulator> world)
    : world_(std::move(world)), outline_(world_->task().physics) {}

std::optional<Plan> StrokePlanner::plan(const WorldState& state, NumpyGenerator& random) {
  std::optional<Trial> best = bestStroke(state, random);
  if (!best || errorOf(best->plan.end) > kWorthwhile * errorOf(state)) {
    if (std::optional<Trial> first = bestOfTwo(state, random)) {
      best = std::move(first);
    }
  }
  return best ? std::optional(std::move(best->plan)) : std::nullopt;
}

std::optional<StrokePlanner::Trial> StrokePlanner::bestStroke(const WorldState& state, NumpyGenerator& random) {
  std::optional<Trial> best;
  int trials = 0;
  for (const Probe& probe : probesAround(state, kPoints, kAngles, random.random())) {
    if (trials == kTrials) {
      break;
    }
    if (std::optional<Trial> tried = trial(state, probe.stroke)) {
      ++trials;
      if (isCheaper(*tried, best)) {
        best = std::move(tried);
      }
    }
  }
  if (best) {
    refine(*best, state, random);
  }
  return best;
}

void StrokePlanner::refine(Trial& best, const WorldState& state, NumpyGenerator& random) {
  boost::random::normal_distribution<double> normal;
  double spread = 1.0;
  for (int i = 0; i < kRefinements; ++i) {
    Stroke stroke = best.stroke;
    stroke.share += spread * kShareSpread * normal(random.bits());
    stroke.angle += spread * kAngleSpread * normal(random.bits());
    stroke.travel = std::max(kLeastTravel, stroke.travel + spread * kTravelSpread * normal(random.bits()));
    std::optional<Trial> tried = trial(state, stroke);
    if (tried && tried->cost < best.cost) {
      best = std::move(*tried);
    } else {
      spread = std::max(kLeastSpread, kNarrowing * spread);
    }
  }
}

std::optional<StrokePlanner::Trial> StrokePlanner::bestOfTwo(const WorldState& state, NumpyGenerator& random) {
  std::optional<Trial> best;
  const double shift = random.random();
  const auto consider = [&](const Stroke& stroke) {
    std::optional<Trial> first = trial(state, stroke);
    if (!first || distanceOfTees(first->plan.end, state, task().physics.centerOfMass()) < kLeastMotion) {
      return;
    }
    const std::vector<Probe> seconds = probesAround(first->plan.end, kLookaheadPoints, kStraight, random.random());
    if (seconds.empty()) {
      return;
    }
    first->cost = seconds.front().cost + kPriceOfStep * static_cast<double>(first->plan.references.size());
    if (isCheaper(*first, best)) {
      best = std::move(first);
    }
  };
  for (int i = 0; i < kLookaheadPoints; ++i) {
    for (const double angle : kLookaheadAngles) {
      for (const double travel : kLookaheadTravels) {
        consider({(i + shift) / kLookaheadPoints, angle, travel});
      }
    }
  }
  return best;
}

/// Probes of points at equal distances around the tee, the first after a share `shift` of one; the cheapest first.
std::vector<StrokePlanner::Probe> StrokePlanner::probesAround(const WorldState& state, int points,
                                                              Span<const double> angles, double shift) {
  std::vector<Probe> probes;
  for (int i = 0; i < points; ++i) {
    for (const double angle : angles) {
      if (const std::optional<Probe> probed = probe(state, {(i + shift) / points, angle})) {
        probes.push_back(*probed);
      }
    }
  }
  std::stable_sort(probes.begin(), probes.end(), [](const Probe& a, const Probe& b) { return a.cost < b.cost; });
  return probes;
}

/// The aimed stroke with the best length; none if the pusher has no room behind the tee.
std::optional<StrokePlanner::Probe> StrokePlanner::probe(const WorldState& state, const Stroke& aim) {
  const std::optional<Line> line = lineOf(state, aim);
  if (!line) {
    return std::nullopt;
  }
  const double way = (line->begin - state.pusher_position).norm();
  const int steps_before = kTypicalDelay + static_cast<int>(way / kTypicalApproachStep);
  WorldState before = state;
  before.pusher_position = line->begin;
  before.pusher_velocity.setZero();
  world_->reset(before);
  std::optional<Probe> best;
  for (int step = 1; step <= kMostProbeSteps; ++step) {
    const Vector2d reference = line->at(std::min(step * kPushStep, kMostTravel));
    if (!isOnTable(reference)) {
      break;
    }
    const WorldState after = stepToward(reference);
    for (int part = 1; part <= kParts; ++part) {
      const WorldState end = between(before, after, static_cast<double>(part) / kParts);
      const double travel = (end.pusher_position - line->begin).dot(line->direction);
      const Probe probed = {{aim.share, aim.angle, travel}, costOf(end, steps_before + step)};
      if (isCheaper(probed, best)) {
        best = probed;
      }
    }
    before = after;
  }
  return best;
}

/// The stroke with the fastest approach that does not move the tee; none if there is no way to where it begins.
std::optional<StrokePlanner::Trial> StrokePlanner::trial(const WorldState& state, const Stroke& stroke) {
  const std::optional<Line> line = lineOf(state, stroke);
  if (!line || !isOnTable(line->at(stroke.travel))) {
    return std::nullopt;
  }
  const std::vector<Vector2d> way = wayTo(line->begin, state);
  if (way.empty()) {
    return std::nullopt;
  }
  std::optional<Trial> best;
  for (const double step : kApproachSteps) {
    world_->reset(state);
    Plan plan;
    approach(plan, pointsAlong(way, step), line->begin);
    const bool bumps = distanceOfTees(plan.end, state, task().physics.centerOfMass()) > kBumpDistance;
    push(plan, *line, stroke.travel);
    const double cost = costOf(plan.end, static_cast<int>(plan.references.size())) + (bumps ? kPriceOfBump : 0.0);
    if (Trial tried{stroke, std::move(plan), cost}; isCheaper(tried, best)) {
      best = std::move(tried);
    }
    if (!bumps) {
      break;
    }
  }
  return best;
}

/// Way of a stroke's kind that begins where the pusher has room; none if it has too little, or that is off the table.
std::optional<StrokePlanner::Line> StrokePlanner::lineOf(const WorldState& state, const Stroke& stroke) const {
  const OutlinePoint aim = outline_.at(stroke.share);
  const Vector2d direction = Eigen::Rotation2Dd(stroke.angle) * aim.inward;
  for (int step = 0; step < kMostRoomSteps; ++step) {
    const Vector2d begin = aim.point - (task().physics.pusher_radius + step * kRoomStep) * direction;
    if (outline_.gap(begin) >= kRoom) {
      const Eigen::Isometry2d tee = placementOfTee(state);
      const Line line = {tee * begin, tee.linear() * direction};
      return isOnTable(line.begin) ? std::optional(line) : std::nullopt;
    }
  }
  return std::nullopt;
}

/// Corners of a way around the tee from where the pusher is, in the table frame; empty if there is none.
std::vector<Vector2d> StrokePlanner::wayTo(const Vector2d& point, const WorldState& state) const {
  const Eigen::Isometry2d tee = placementOfTee(state);
  std::vector<Vector2d> way = outline_.wayAround(tee.inverse() * state.pusher_position, tee.inverse() * point, kRoom,
                                                 [&](const Vector2d& corner) { return isOnTable(tee * corner); });
  for (Vector2d& corner : way) {
    corner = tee * corner;
  }
  return way;
}

void StrokePlanner::approach(Plan& plan, const std::vector<Vector2d>& points, const Vector2d& goal) {
  for (const Vector2d& point : points) {
    follow(plan, point);
  }
  follow(plan, goal);
  for (int i = 1; i < kMostSettlingSteps && (plan.end.pusher_position - goal).norm() > kSettled; ++i) {
    follow(plan, goal);
  }
}

void StrokePlanner::push(Plan& plan, const Line& line, double travel) {
  for (int step = 1; step * kPushStep < travel; ++step) {
    follow(plan, line.at(step * kPushStep));
  }
  for (int i = 0; i <= kFinalSteps; ++i) {
    follow(plan, line.at(travel));
  }
}

/// Takes the control step with which a plan goes on.
void StrokePlanner::follow(Plan& plan, const Vector2d& reference) {
  plan.references.push_back(reference);
  plan.end = stepToward(reference);
}

WorldState StrokePlanner::stepToward(const Vector2d& reference) {
  world_->step(actionToward(reference, world_->state().pusher_position, task()));
  return world_->state();
}

/// Whether walls leave room for a pusher at `point`.
bool StrokePlanner::isOnTable(const Vector2d& point) const {
  const Physics& physics = task().physics;
  return reachOf(point, physics) < physics.wall_inner_face - physics.pusher_radius - kWallMargin;
}

/// [m] How far the tee is from the target.
double StrokePlanner::errorOf(const WorldState& state) const {
  WorldState target;
  target.tee_position = task().target.position;
  target.tee_yaw = task().target.yaw;
  return distanceOfTees(state, target, task().physics.centerOfMass());
}

/// Cost of a state after so many control steps.
double StrokePlanner::costOf(const WorldState& state, int steps) const {
  return std::log(errorOf(state) + kSmallestError) + kPriceOfStep * steps;
}

}  // namespace pusht
