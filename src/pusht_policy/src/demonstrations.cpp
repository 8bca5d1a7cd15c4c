// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/demonstrations.hpp"

#include <pusht_msgs/DemonstrationEnd.h>
#include <pusht_msgs/DemonstrationStep.h>
#include <std_msgs/String.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "pusht_policy/formats.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/ros/bag_file.hpp"
#include "pusht_task/spawn.hpp"

namespace pusht {
namespace {

constexpr int kMaxEpisodes = 1'000'000;

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

void write(BagFile& bag, Stamps& stamps, std::uint64_t seed, const Rollout& rollout) {
  const Trace& trace = rollout.trace();
  for (std::size_t step = 0; step < trace.steps(); ++step) {
    auto message = stamped<pusht_msgs::DemonstrationStep>(seed, stamps.next());
    message.step = static_cast<std::uint32_t>(step);
    const Observation observation = observe(trace.states[step]);
    std::copy(observation.begin(), observation.end(), message.observation.begin());
    std::copy(trace.actions[step].begin(), trace.actions[step].end(), message.action.begin());
    bag.write(kDemonstrationStepTopic, message.header.stamp, message);
  }
  auto end = stamped<pusht_msgs::DemonstrationEnd>(seed, stamps.next());
  end.steps = static_cast<std::uint32_t>(trace.steps());
  end.success = rollout.success();
  bag.write(kDemonstrationEndTopic, end.header.stamp, end);
}

}  // namespace

void DemonstrationPlan::validate() const {
  if (episodes < 1 || episodes > kMaxEpisodes) {
    throw InvalidInput("episodes " + std::to_string(episodes) + ": must be from 1 to " + std::to_string(kMaxEpisodes));
  }
  if (seed > std::numeric_limits<std::uint64_t>::max() - static_cast<std::uint64_t>(episodes)) {
    throw InvalidInput("seed " + std::to_string(seed) + ": seed + episodes must be below 2^64");
  }
}

DemonstrationTally recordDemonstrations(const DemonstrationPlan& plan, Simulator& world, Policy& demonstrator,
                                        const nlohmann::json& origin, const std::filesystem::path& path,
                                        const std::function<bool(const DemonstrationTally&)>& report) {
  plan.validate();
  BagFile bag(path);
  Stamps stamps;
  nlohmann::json beginning = origin;
  beginning["format"] = kDemonstrationFormat;
  std_msgs::String text;
  text.data = beginning.dump();
  bag.write(kDemonstrationOriginTopic, stamps.next(), text);
  DemonstrationTally tally;
  while (tally.episodes < plan.episodes) {
    const std::uint64_t seed = plan.seed + static_cast<std::uint64_t>(tally.episodes);
    const Rollout rollout = runClosedLoop(world, spawn(seed), demonstrator, kHorizon);
    write(bag, stamps, seed, rollout);
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
