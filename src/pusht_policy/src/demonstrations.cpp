// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/demonstrations.hpp"

#include <pusht_msgs/DemonstrationEnd.h>
#include <pusht_msgs/DemonstrationStep.h>
#include <rosbag/bag.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/spawn.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxEpisodes = 1'000'000;

/// A bag that is written aside and appears at its path when it is complete, or not at all.
class BagFile {
 public:
  explicit BagFile(std::filesystem::path path) : path_(std::move(path)), aside_(asidePath(path_)) {
    std::error_code error;
    if (path_.filename().empty() || std::filesystem::symlink_status(path_, error).type() != fs::file_type::not_found) {
      throw InvalidInput("bag '" + path_.string() + "': must be the name of a file that does not exist yet");
    }
    attempt([this] { bag_->open(aside_.string(), rosbag::bagmode::Write); });
  }
  BagFile(const BagFile&) = delete;
  BagFile& operator=(const BagFile&) = delete;
  ~BagFile() {
    try {
      bag_->close();
    } catch (const rosbag::BagException&) {
      // On a full disk a bag cannot be closed, and one that is destroyed while open ends the process.
      (void)bag_.release();  // NOLINT(bugprone-unused-return-value)
    }
    std::error_code ignored;
    fs::remove(aside_, ignored);
  }

  template <class Message>
  void write(const std::string& topic, const Message& message) {
    attempt([&] { bag_->write(topic, message.header.stamp, message); });
  }

  void finish() {
    attempt([this] { bag_->close(); });
    moveIntoPlace(aside_, path_);
  }

 private:
  template <class Action>
  void attempt(const Action& action) const {
    try {
      action();
    } catch (const rosbag::BagException& error) {
      throw RuntimeFault("cannot write " + path_.string() + ": " + error.what());
    }
  }

  std::filesystem::path path_;
  std::filesystem::path aside_;
  std::unique_ptr<rosbag::Bag> bag_ = std::make_unique<rosbag::Bag>();
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

void write(BagFile& bag, Stamps& stamps, std::uint64_t seed, const Rollout& rollout) {
  const Trace& trace = rollout.trace();
  for (std::size_t step = 0; step < trace.steps(); ++step) {
    auto message = stamped<pusht_msgs::DemonstrationStep>(seed, stamps.next());
    message.step = static_cast<std::uint32_t>(step);
    const Observation observation = observe(trace.states[step]);
    std::copy(observation.begin(), observation.end(), message.observation.begin());
    std::copy(trace.actions[step].begin(), trace.actions[step].end(), message.action.begin());
    bag.write(kDemonstrationStepTopic, message);
  }
  auto end = stamped<pusht_msgs::DemonstrationEnd>(seed, stamps.next());
  end.steps = static_cast<std::uint32_t>(trace.steps());
  end.success = rollout.success();
  bag.write(kDemonstrationEndTopic, end);
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
                                        const std::filesystem::path& path,
                                        const std::function<bool(const DemonstrationTally&)>& report) {
  plan.validate();
  BagFile bag(path);
  Stamps stamps;
  DemonstrationTally tally;
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
  bag.finish();
  return tally;
}

}  // namespace pusht
