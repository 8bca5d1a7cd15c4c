// SPDX-License-Identifier: BSD-3-Clause
/// The loop between a policy and a world: delays, noise, hold and scale, apart from any simulator and any policy.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pusht_task/parameters.hpp"
#include "pusht_task/policy.hpp"
#include "pusht_task/task.hpp"

namespace pusht {

/// What the names of the loop's parameters begin with where they stand beside those of a simulator.
constexpr const char* kLoopPrefix = "loop.";

/// Parameters of the loop: what happens to an observation on its way to the policy, and to a command on its way to the
/// world, in this order: noise of the sensor, delay, policy every h-th step, clip, scale, delay, noise of the actuator.
/// The defaults change nothing. `preset` sets those that are not set by name: `none`, or `tracker`, a camera that
/// follows tags on pusher and tee (docs/loop.md has its sources).
const std::vector<ParameterDescriptor>& loopParameters();

/// Parameters of the loop with their defaults.
ParameterSet plainLoop();

/// Whether all parameters of a loop have their defaults.
bool isPlain(const ParameterSet& loop);

/// "action_delay" if `name` is "loop.action_delay"; empty if it does not begin with the prefix.
std::string loopParameterOf(const std::string& name);

/// Name and value of a setting of the loop, from "NAME=VALUE" or from the word of a preset. Throws InvalidInput for any
/// other word.
std::pair<std::string, std::string> loopSettingFrom(const std::string& text);

/// Loop for people: "tracker", "tracker, action_delay 2", "observation_noise_position 0.01"; empty if it is plain.
std::string textOf(const ParameterSet& loop);

/// Sets a parameter of the loop by its name without the prefix. Throws as ParameterSet::set(), with the whole name.
void setOfLoop(ParameterSet& loop, const std::string& name, const std::string& text);

/// `policy` in loops with these parameters, one for each role. Random numbers come from the seed of each rollout, a
/// stream for each kind of noise, so a parameter changes the size of its noise and no other number. It is `policy`
/// itself if both loops are plain. A role whose loop is plain has the policy's actions, to the last bit.
/// Commands that are not finite stay so, for the protocol to refuse.
/// In a task whose commands are positions, noise of the actuator is the noise of positions that changes the pusher's
/// steady speed by `action_noise`. `task` must outlive the policy.
std::unique_ptr<Policy> looped(std::unique_ptr<Policy> policy, const ParameterSet& reference,
                               const ParameterSet& engine, const Task& task = fullCircle());

}  // namespace pusht
