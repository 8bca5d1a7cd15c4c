// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/live/broadcast.hpp"

#include <tf2_msgs/TFMessage.h>

#include <utility>

#include "sim2sim_eval/bag/messages.hpp"

namespace sim2sim {
namespace {

constexpr std::uint32_t kQueue = 1000;

/// Where nobody can follow every control step, and in the bag, the picture is drawn every so many of them.
constexpr int kStepsPerPicture = 10;

Picture makePicture(const Cast& cast) {
  const auto name = [&](Mode mode) { return recordOf(cast.describe(mode)).title; };
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
      markers_(node_.advertise<visualization_msgs::MarkerArray>("markers", kQueue)),
      repeating_(node_.createSteadyTimer(ros::WallDuration(1.0), [this](const ros::SteadyTimerEvent&) { repeat(); })) {}

void Broadcast::begin(const RunConfiguration& configuration, Cast& cast, std::unique_ptr<RunBag> bag) {
  configuration_ = configuration;
  bag_ = std::move(bag);
  finished_.reset();
  summary_ = summaryMessage(configuration_, std::nullopt, ros::Time());
  summary_topic_.publish(summary_);
  picture_ = makePicture(cast);
  fixed_frames_.sendTransform(picture_->frames());
  if (bag_) {
    tf2_msgs::TFMessage frames;
    frames.transforms = picture_->frames();
    bag_->write(frames, cast.stamps().now());
  }
  const std::lock_guard<std::mutex> lock(mutex_);
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
  const bool in_turn = episode.steps() % kStepsPerPicture == 0;
  if (paced || in_turn) {
    draw(episode, stamp, in_turn);
  }
  return divergence;
}

void Broadcast::draw(const Episode& episode, const ros::Time& stamp, bool recorded) {
  const visualization_msgs::MarkerArray update = picture_->update(configuration_, episode, finished_);
  if (bag_ && recorded) {
    bag_->write(scene_, stamp);  // again: a player may begin anywhere
    bag_->write(update, stamp);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  update_ = update;
  markers_.publish(update_);
}

void Broadcast::repeat() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  markers_.publish(scene_);
  markers_.publish(update_);
}

void Broadcast::finish(const Episode& episode, const EpisodeResult& result, const Summary& finished,
                       const ros::Time& stamp) {
  finished_ = finished;
  summary_ = summaryMessage(configuration_, finished_, stamp);
  const Protocol& protocol = configuration_.protocol;
  const pusht_msgs::EpisodeResult message = toMessage(protocol, result, stamp);
  episode_.publish(message);
  summary_topic_.publish(summary_);
  if (bag_) {
    bag_->writeProbes(protocol, episode, stamp);
    bag_->write(message);
    bag_->write(summary_);
  }
  draw(episode, stamp, true);
}

void Broadcast::end() {
  if (const std::unique_ptr<RunBag> bag = std::move(bag_)) {
    bag->finish();
  }
}

}  // namespace sim2sim
