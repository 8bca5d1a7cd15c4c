// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/demonstrations.hpp"

#include <pusht_msgs/DemonstrationEnd.h>
#include <pusht_msgs/DemonstrationStep.h>
#include <pusht_msgs/DemonstrationWorld.h>
#include <std_msgs/String.h>

#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "pusht_policy/formats.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/spawn.hpp"
#include "sim2sim_serving/bag_file.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace pusht {
namespace {

constexpr int kMaxEpisodes = 1'000'000;

/// World that takes each action with normal noise on it.
class NoisyWorld final : public Simulator {
 public:
  /// `seed` chooses the stream of the noise. `deviation` is that of each axis [unit of an action].
  NoisyWorld(Simulator& world, std::uint64_t seed, double deviation)
      : Simulator("", world.startTolerance(), world.task()),
        world_(world),
        generator_(seed, "action noise"),
        noise_(0.0, deviation) {}

 private:
  void doReset(const WorldState& state) override { world_.reset(state); }

  void doStep(const Action& action) override {
    Action noisy = action;
    for (float& component : noisy) {
      component += static_cast<float>(noise_(generator_.bits()));
    }
    world_.step(noisy);
  }

  WorldState doState() const override { return world_.state(); }

  Simulator& world_;
  NumpyGenerator generator_;
  boost::random::normal_distribution<double> noise_;
};

/// Stamps grow by a control step through the whole bag.
class Stamps {
 public:
  ros::Time next() { return ros::Time().fromNSec(++count_ * kNanosecondsPerControlStep); }

 private:
  static constexpr std::uint64_t kNanosecondsPerControlStep = 100'000'000;
  std::uint64_t count_ = 0;
};

template <class Message>
Message stamped(std::uint64_t seed, const ros::Time& stamp) {
  Message message;
  message.header.frame_id = "table";
  message.header.stamp = stamp;
  message.seed = seed;
  return message;
}

void write(BagFile& bag, Stamps& stamps, std::uint64_t seed, const DemonstrationWorld& world, const Rollout& rollout) {
  const Task& task = world.world->task();
  auto beginning = stamped<pusht_msgs::DemonstrationWorld>(seed, stamps.next());
  beginning.simulator = world.simulator;
  for (const auto& [name, value] : world.drawn) {
    beginning.drawn.push_back(parameter(name, value));
  }
  bag.write(kDemonstrationWorldTopic, beginning.header.stamp, beginning);
  const Trace& trace = rollout.trace();
  for (std::size_t step = 0; step < trace.steps(); ++step) {
    auto message = stamped<pusht_msgs::DemonstrationStep>(seed, stamps.next());
    message.step = static_cast<std::uint32_t>(step);
    const Observation observation = observe(trace.states[step], task);
    std::copy(observation.begin(), observation.end(), message.observation.begin());
    std::copy(trace.actions[step].begin(), trace.actions[step].end(), message.action.begin());
    bag.write(kDemonstrationStepTopic, message.header.stamp, message);
  }
  auto end = stamped<pusht_msgs::DemonstrationEnd>(seed, stamps.next());
  end.steps = static_cast<std::uint32_t>(trace.steps());
  end.success = rollout.success();
  bag.write(kDemonstrationEndTopic, end.header.stamp, end);
}

Rollout demonstrated(const DemonstrationWorld& world, std::uint64_t seed, double action_noise, Policy& demonstrator) {
  const WorldState start = spawn(seed, world.world->task());
  if (action_noise == 0.0) {
    return runClosedLoop(*world.world, start, demonstrator, kHorizon);
  }
  NoisyWorld noisy(*world.world, seed, action_noise);
  return runClosedLoop(noisy, start, demonstrator, kHorizon);
}

}  // namespace

void DemonstrationPlan::validate() const {
  if (episodes < 1 || episodes > kMaxEpisodes) {
    throw InvalidInput("episodes " + std::to_string(episodes) + ": must be from 1 to " + std::to_string(kMaxEpisodes));
  }
  const std::uint64_t last = task.get().last_spawn_seed;
  if (seed > last || static_cast<std::uint64_t>(episodes) - 1 > last - seed) {
    throw InvalidInput("seed " + std::to_string(seed) + ": seed + episodes - 1 must be at most " +
                       std::to_string(last));
  }
  const double most_noise = kActionLimit * actionPerSpeed(task);
  if (!(action_noise >= 0.0 && action_noise <= most_noise)) {
    throw InvalidInput("action noise " + shortestText(action_noise) + ": must be from 0 to " +
                       shortestText(most_noise) + (task.get().frame.isTables() ? " m/s" : " " + task.get().frame.unit));
  }
}

DemonstrationTally recordDemonstrations(const DemonstrationPlan& plan, const DemonstrationWorlds& worlds,
                                        Policy& demonstrator, const nlohmann::json& origin,
                                        const std::filesystem::path& path,
                                        const std::function<bool(const DemonstrationTally&)>& report) {
  plan.validate();
  BagFile bag(path);
  Stamps stamps;
  nlohmann::json beginning = origin;
  beginning["format"] = kDemonstrationFormat;
  beginning["action_noise"] = plan.action_noise;  // [unit of an action]
  if (&plan.task.get() != &fullCircle()) {
    beginning["task"] = textOf(plan.task);
  }
  std_msgs::String text;
  text.data = beginning.dump();
  bag.write(kDemonstrationOriginTopic, stamps.next(), text);
  DemonstrationTally tally;
  while (tally.episodes < plan.episodes) {
    const std::uint64_t seed = plan.seed + static_cast<std::uint64_t>(tally.episodes);
    const DemonstrationWorld world = worlds(seed);
    const Rollout rollout = demonstrated(world, seed, plan.action_noise, demonstrator);
    write(bag, stamps, seed, world, rollout);
    ++tally.episodes;
    tally.successes += rollout.success() ? 1 : 0;
    tally.frames += rollout.steps();
    if (!report(tally)) {
      throw RuntimeFault("interrupted after " + std::to_string(tally.episodes) + " of " +
                         std::to_string(plan.episodes) + " demonstrations; nothing was written");
    }
  }
  bag.finish();
  return tally;
}

}  // namespace pusht
