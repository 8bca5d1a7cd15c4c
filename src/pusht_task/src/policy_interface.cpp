// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/policy_interface.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>

#include "pusht_task/gym_pusht.hpp"

namespace pusht {
namespace {

constexpr int kStateNumbers = 5;

/// State of an observation in gym-pusht's frame, at rest.
gym_pusht::State stateOf(const Observation& observation) {
  gym_pusht::State state;
  state.pusher = {observation[0], observation[1]};
  state.tee = {observation[2], observation[3]};
  state.angle = std::atan2(static_cast<double>(observation[4]), static_cast<double>(observation[5]));
  return state;
}

/// Whether observations and actions are in gym-pusht's frame, and actions positions.
bool isInPixels(const Task& task) {
  const TaskFrame& frame = task.frame;
  const TaskFrame& pixels = gymPusht().frame;
  return task.physics.drive == Drive::kPosition && frame.unit == pixels.unit && frame.per_meter == pixels.per_meter &&
         frame.middle == pixels.middle && frame.y_down == pixels.y_down && frame.bar_center == pixels.bar_center;
}

/// Whether the tee has the points that keypoints are.
bool hasGymPushtsTee(const Physics& physics) {
  const Physics& gyms = gymPusht().physics;
  return physics.bar_half_length == gyms.bar_half_length && physics.bar_half_width == gyms.bar_half_width &&
         physics.stem_half_length == gyms.stem_half_length && physics.stem_half_width == gyms.stem_half_width &&
         physics.stem_offset == gyms.stem_offset;
}

template <class Points>
Span<float>::iterator append(const Points& points, Span<float>::iterator place) {
  for (const Eigen::Vector2d& point : points) {
    *place++ = static_cast<float>(point.x());
    *place++ = static_cast<float>(point.y());
  }
  return place;
}

}  // namespace

int PolicyInterface::numbers() const {
  return name == Name::kFullCircle ? static_cast<int>(std::tuple_size_v<Observation>)
         : name == Name::kGymState ? kStateNumbers
                                   : 2 * (keypoints + 1);
}

void PolicyInterface::look(const Observation& observation, Span<float> seen) const {
  if (name == Name::kFullCircle) {
    std::copy(observation.begin(), observation.end(), seen.begin());
    return;
  }
  const gym_pusht::State state = stateOf(observation);
  if (name == Name::kGymState) {
    std::copy_n(observation.begin(), kStateNumbers - 1, seen.begin());
    seen[kStateNumbers - 1] = static_cast<float>(state.angle < 0.0 ? state.angle + 2.0 * kPi : state.angle);
    return;
  }
  auto place = seen.begin();
  const std::array<Eigen::Vector2d, 1> agent = {state.pusher};
  if (agent_first) {
    place = append(agent, place);
  }
  place = keypoints == static_cast<int>(gym_pusht::kCorners) ? append(gym_pusht::keypoints(state), place)
                                                             : append(gym_pusht::scatteredKeypoints(state), place);
  if (!agent_first) {
    append(agent, place);
  }
}

bool PolicyInterface::fits(const Task& task) const {
  if (name == Name::kFullCircle) {
    return task.frame.isTables() && task.physics.drive == Drive::kVelocity;
  }
  return isInPixels(task) && (name == Name::kGymState || hasGymPushtsTee(task.physics));
}

std::string PolicyInterface::text() const {
  const std::string& key = policyInterfaceNames()[static_cast<std::size_t>(name)];
  return name != Name::kGymKeypoints
             ? key
             : key + " (" + std::to_string(keypoints) + ", agent " + (agent_first ? "first" : "last") + ")";
}

bool PolicyInterface::operator==(const PolicyInterface& other) const {
  return std::tie(name, keypoints, agent_first) == std::tie(other.name, other.keypoints, other.agent_first);
}

const std::vector<std::string>& policyInterfaceNames() {
  static const std::vector<std::string> names = {"full_circle", "gym_state", "gym_keypoints"};
  return names;
}

std::vector<std::string> policyInterfacesOf(const Task& task) {
  std::vector<std::string> fitting;
  for (std::size_t i = 0; i < policyInterfaceNames().size(); ++i) {
    if (PolicyInterface{static_cast<PolicyInterface::Name>(i)}.fits(task)) {
      fitting.push_back(policyInterfaceNames()[i]);
    }
  }
  return fitting;
}

}  // namespace pusht

/// What a policy of gym-pusht sees of observations [rows][10], for programs in Python: fills `seen`, and returns how
/// many numbers a row has. `keypoints`: 0 for the interface gym_state, 8 or 9; for another number it returns 0.
extern "C" int seenOfGymPusht(int keypoints, int agent_first, const float* observations, std::size_t rows,
                              float* seen) {
  using pusht::PolicyInterface;
  constexpr int kCorners = pusht::gym_pusht::kCorners;
  if (keypoints != 0 && keypoints != kCorners && keypoints != static_cast<int>(pusht::gym_pusht::kScattered)) {
    return 0;
  }
  const PolicyInterface interface = {
      keypoints == 0 ? PolicyInterface::Name::kGymState : PolicyInterface::Name::kGymKeypoints, keypoints,
      agent_first != 0};
  const auto numbers = static_cast<std::size_t>(interface.numbers());
  for (std::size_t row = 0; row < rows; ++row) {
    pusht::Observation observation{};
    std::copy_n(observations + row * observation.size(), observation.size(), observation.begin());
    interface.look(observation, {seen + row * numbers, numbers});
  }
  return interface.numbers();
}
