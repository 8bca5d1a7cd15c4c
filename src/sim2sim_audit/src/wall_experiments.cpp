// SPDX-License-Identifier: BSD-3-Clause
// Places of the walls, for the pusher and for the tee.
#include <array>
#include <cmath>
#include <limits>

#include "experiments.hpp"
#include "pusht_task/constants.hpp"

namespace sim2sim {
namespace {

struct Wall {
  Eigen::Vector2d outward;
  Property for_pusher;
  Property for_tee;
};

const std::array<Wall, 4>& walls() {
  static const std::array<Wall, 4> all = {{{{0.0, 1.0}, Property::kWallUp, Property::kTeeAtWallUp},
                                           {{0.0, -1.0}, Property::kWallDown, Property::kTeeAtWallDown},
                                           {{1.0, 0.0}, Property::kWallRight, Property::kTeeAtWallRight},
                                           {{-1.0, 0.0}, Property::kWallLeft, Property::kTeeAtWallLeft}}};
  return all;
}

/// [m] Middle between the walls.
Eigen::Vector2d middleOf(const Bench& bench) {
  return {bench.physics().wall_middle[0], bench.physics().wall_middle[1]};
}

void wallsByTouch(Bench& bench, Measurements& found) {
  // Nearer to the wall's inner face than to the outer one, out of which a pusher would not be held.
  const double in_wall = bench.physics().wall_inner_face + 0.25 * pusht::dynamics::kWallThickness;
  constexpr double kClear = 0.1;  // [m]
  pusht::WorldState scene;
  for (const Wall& wall : walls()) {
    const Eigen::Vector2d beside(-wall.outward.y(), wall.outward.x());
    scene.tee_position = (0.15 - 0.5 * bench.narrower()) * beside - 0.1 * wall.outward;
    const auto distance =
        touchDistance(bench, {scene, middleOf(bench) - 0.2 * beside, wall.outward, in_wall, in_wall - kClear});
    found.set(wall.for_pusher,
              distance ? *distance + found.need(Property::kPusherRadius) : std::numeric_limits<double>::infinity());
  }
}

/// The pusher pushes the tee against each wall, back of the bar first, until nothing moves.
void wallsByTee(Bench& bench, Measurements& found) {
  constexpr int kSteps = 8;
  constexpr double kApproach = 0.04;  // [m]
  constexpr double kLeastWay = 0.02;  // [m]
  const double face = bench.physics().wall_inner_face;
  const double back = found.need(Property::kBarHalfWidth) + found.need(Property::kOriginY);
  const double reach =
      found.need(Property::kStemEnd) - found.need(Property::kOriginY) + found.need(Property::kPusherRadius);
  for (const Wall& wall : walls()) {
    pusht::WorldState start;
    const Eigen::Vector2d beside(-wall.outward.y(), wall.outward.x());
    start.tee_yaw = pusht::wrapAngle(std::atan2(wall.outward.y(), wall.outward.x()) - 0.5 * pusht::kPi);
    start.tee_position = middleOf(bench) + (face - back - kApproach) * wall.outward + 0.1 * beside;
    start.pusher_position = start.tee_position - reach * wall.outward - found.need(Property::kOriginX) * beside;
    const auto states = bench.run(start, std::vector<Eigen::Vector2d>(kSteps, 0.3 * wall.outward));
    const double place = (states.back().tee_position - middleOf(bench)).dot(wall.outward) + back;
    if ((states.back().tee_position - states.front().tee_position).dot(wall.outward) < kLeastWay) {
      found.fail(wall.for_tee, "a push towards the wall does not move the tee");
      continue;
    }
    constexpr double kBeyond = 0.02;  // [m] nothing that gives way is pushed so far into a wall
    found.set(wall.for_tee, place > face + kBeyond ? std::numeric_limits<double>::infinity() : place);
  }
}

}  // namespace

std::vector<Experiment> wallExperiments() {
  return {{"walls by touch",
           {Property::kWallUp, Property::kWallDown, Property::kWallRight, Property::kWallLeft},
           wallsByTouch},
          {"walls by the tee",
           {Property::kTeeAtWallUp, Property::kTeeAtWallDown, Property::kTeeAtWallRight, Property::kTeeAtWallLeft},
           wallsByTee}};
}

}  // namespace sim2sim
