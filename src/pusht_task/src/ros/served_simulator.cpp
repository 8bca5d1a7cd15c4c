// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/ros/served_simulator.hpp"

#include <algorithm>

#include "pusht_task/constants.hpp"
#include "pusht_task/ros/conversions.hpp"

namespace pusht {

void StampSource::advance() { now_ += ros::Duration(kControlStep); }

void StampSource::startAbove(const ros::Time& stamp) { now_ = std::max(now_, stamp); }

ServedSimulator::ServedSimulator(const Peer& peer, const StampSource& stamps)
    : stamps_(stamps), configure_(peer, "configure"), reset_(peer, "reset"), step_(peer, "step") {}

void ServedSimulator::announce(std::uint64_t episode, int horizon) {
  episode_ = episode;
  horizon_ = horizon;
}

Parameters ServedSimulator::configure(const Parameters& changes) {
  pusht_msgs::ConfigureRequest request;
  request.parameters = changes;
  request.end_episode = 1;
  return configure_.call(request).parameters;
}

void ServedSimulator::doReset(const WorldState& state) {
  pusht_msgs::ResetRequest request;
  request.start = {toMessage(state)};
  request.episode = episode_;
  request.horizon = static_cast<std::uint32_t>(horizon_);
  request.stamp = stamps_.now();
  state_ = fromMessage(reset_.call(request).state);
  next_step_ = 0;
}

void ServedSimulator::doStep(const Action& action) {
  pusht_msgs::StepRequest request;
  request.episode = episode_;
  request.step = next_step_;
  request.action = {action[0], action[1]};
  request.stamp = stamps_.now();
  state_ = fromMessage(step_.call(request).state);
  ++next_step_;
}

}  // namespace pusht
