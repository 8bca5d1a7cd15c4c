// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/broadcast.hpp"

#include <ros/single_subscriber_publisher.h>

#include <utility>

#include "sim2sim_eval/messages.hpp"

namespace sim2sim {
namespace {

constexpr std::uint32_t kQueue = 1000;

/// Where nobody can follow every control step, and in the bag, the picture is drawn every so many of them.
constexpr int kStepsPerPicture = 10;

Picture makePicture(const Cast& cast) {
  const auto name = [&](Mode mode) { return displayName(cast.describe(mode).name); };
  const auto prefix = [&](Mode mode) { return cast.describe(mode).frame_prefix; };
  return Picture({{{prefix(kReferenceClosed), name(kReferenceClosed) + ", closed loop"},
                   {prefix(kEngineClosed), name(kEngineClosed) + ", closed loop"},
                   {prefix(kEngineReplay), name(kEngineReplay) + ", replay"}}});
}

}  // namespace

Broadcast::Broadcast(const ros::NodeHandle& node)
    : node_(node),
      divergence_(node_.advertise<pusht_msgs::Divergence>("divergence", kQueue)),
      episode_(node_.advertise<pusht_msgs::EpisodeResult>("episode", kQueue)),
      summary_topic_(node_.advertise<pusht_msgs::Summary>("summary", 1, true)),
      markers_(node_.advertise<visualization_msgs::MarkerArray>(
          "markers", kQueue, [this](const ros::SingleSubscriberPublisher& subscriber) { greet(subscriber); })) {}

void Broadcast::begin(const RunConfiguration& configuration, const Cast& cast, std::unique_ptr<RunBag> bag) {
  configuration_ = configuration;
  bag_ = std::move(bag);
  finished_.reset();
  summary_ = summaryMessage(configuration_, {}, ros::Time());
  summary_topic_.publish(summary_);
  const std::lock_guard<std::mutex> lock(mutex_);
  picture_ = makePicture(cast);
  scene_ = picture_->scene();
  update_ = {};
  markers_.publish(scene_);
}

pusht_msgs::Divergence Broadcast::step(const Episode& episode, const ros::Time& stamp, bool paced) {
  pusht_msgs::Divergence divergence = divergenceMessage(episode, episode.steps(), stamp);
  divergence_.publish(divergence);
  if (bag_) {
    bag_->writeWorlds(episode, episode.steps(), stamp);
    bag_->write(divergence);
  }
  draw(episode, stamp, paced);
  return divergence;
}

void Broadcast::draw(const Episode& episode, const ros::Time& stamp, bool every_step) {
  const bool in_turn = episode.steps() % kStepsPerPicture == 0 || episode.finished();
  const bool recorded = bag_ && in_turn;
  const bool seen = markers_.getNumSubscribers() > 0 && (every_step || in_turn);
  if (!recorded && !seen) {
    return;
  }
  const visualization_msgs::MarkerArray update = picture_->update(configuration_.policy, episode, finished_);
  if (seen) {
    markers_.publish(update);
  }
  if (recorded) {
    if (episode.steps() == 0) {
      bag_->write(scene_, stamp);
    }
    bag_->write(update, stamp);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  update_ = update;
}

void Broadcast::greet(const ros::SingleSubscriberPublisher& subscriber) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  subscriber.publish(scene_);
  subscriber.publish(update_);
}

void Broadcast::finish(const EpisodeResult& episode, const std::vector<EpisodeResult>& finished,
                       const ros::Time& stamp) {
  finished_ = summarize(finished);
  summary_ = summaryMessage(configuration_, finished, stamp);
  const pusht_msgs::EpisodeResult result = toMessage(episode, stamp);
  episode_.publish(result);
  summary_topic_.publish(summary_);
  if (bag_) {
    bag_->write(result);
    bag_->write(summary_);
  }
}

void Broadcast::end() {
  if (const std::unique_ptr<RunBag> bag = std::move(bag_)) {
    bag->finish();
  }
}

}  // namespace sim2sim
