// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/demonstrations.hpp"

#include <pusht_msgs/DemonstrationEnd.h>
#include <pusht_msgs/DemonstrationStep.h>
#include <rosbag/bag.h>

#include <algorithm>
#include <limits>
#include <string>
#include <system_error>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/spawn.hpp"

namespace pusht {
namespace {

/// Removes the unfinished bag unless it was moved into place.
class UnfinishedBag {
 public:
  explicit UnfinishedBag(std::filesystem::path path) : path_(std::move(path)) {}
  UnfinishedBag(const UnfinishedBag&) = delete;
  UnfinishedBag& operator=(const UnfinishedBag&) = delete;
  ~UnfinishedBag() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }

 private:
  std::filesystem::path path_;
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

void write(rosbag::Bag& bag, Stamps& stamps, std::uint64_t seed, const Rollout& rollout) {
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
  if (episodes < 1) {
    throw InvalidInput("episodes " + std::to_string(episodes) + ": must be >= 1");
  }
  if (seed > std::numeric_limits<std::uint64_t>::max() - static_cast<std::uint64_t>(episodes)) {
    throw InvalidInput("seed " + std::to_string(seed) + ": seed + episodes must be below 2^64");
  }
}

DemonstrationTally recordDemonstrations(const DemonstrationPlan& plan, Simulator& world, Policy& demonstrator,
                                        const std::filesystem::path& path,
                                        const std::function<bool(const DemonstrationTally&)>& report) {
  plan.validate();
  const std::filesystem::path aside = asidePath(path);
  const UnfinishedBag unfinished(aside);
  DemonstrationTally tally;
  try {
    rosbag::Bag bag(aside.string(), rosbag::bagmode::Write);
    Stamps stamps;
    while (tally.episodes < plan.episodes) {
      const std::uint64_t seed = plan.seed + static_cast<std::uint64_t>(tally.episodes);
      Rollout rollout(world, spawn(seed), demonstrator.begin());
      runClosedLoop(rollout, demonstrator, kHorizon);
      write(bag, stamps, seed, rollout);
      ++tally.episodes;
      tally.successes += rollout.success() ? 1 : 0;
      tally.frames += rollout.steps();
      if (!report(tally)) {
        throw RuntimeFault("interrupted after " + std::to_string(tally.episodes) + " of " +
                           std::to_string(plan.episodes) + " demonstrations; nothing was written");
      }
    }
    bag.close();
  } catch (const rosbag::BagException& error) {
    throw RuntimeFault("cannot write " + path.string() + ": " + error.what());
  }
  moveIntoPlace(aside, path);
  return tally;
}

}  // namespace pusht
