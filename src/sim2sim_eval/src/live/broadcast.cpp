// SPDX-License-Identifier: BSD-3-Clause
#include "live/broadcast.hpp"

#include <tf2_msgs/TFMessage.h>

#include <utility>

#include "bag/messages.hpp"
#include "live/captions.hpp"
#include "live/truncated_episode.hpp"

namespace sim2sim {

using visualization_msgs::MarkerArray;

namespace {

constexpr std::uint32_t kQueue = 1000;

/// [control steps] Period of the picture in the bag, and in a run that is too fast to follow by eye.
constexpr int kStepsPerPicture = 10;

/// Caption of a run under way: "policy bc, episode 7, 3.9 s".
std::string progressCaption(const RunConfiguration& run, const Episode& episode) {
  return "policy " + run.policy + ", episode " + std::to_string(episode.index()) + ", " + secondsText(episode.steps());
}

}  // namespace

Broadcast::Broadcast(const ros::NodeHandle& node)
    : node_(node),
      configuration_topic_(node_.advertise<std_msgs::String>("configuration", 1, true)),
      divergence_(node_.advertise<pusht_msgs::Divergence>("divergence", kQueue, true)),
      trace_(node_.advertise<pusht_msgs::Trace>("trace", kQueue)),
      episode_(node_.advertise<pusht_msgs::EpisodeResult>("episode", kQueue)),
      summary_topic_(node_.advertise<pusht_msgs::Summary>("summary", 1, true)),
      markers_(node_.advertise<visualization_msgs::MarkerArray>("markers", kQueue)),
      episodes_service_(node_.advertiseService("episodes", &Broadcast::onEpisodes, this)),
      repeating_(
          node_.createSteadyTimer(ros::WallDuration(1.0), [this](const ros::SteadyTimerEvent&) { republish(); })) {
  showState(RunState::kWaits, "no run yet");
}

void Broadcast::begin(const RunConfiguration& configuration, Picture picture, std::unique_ptr<RunBag> bag,
                      const ros::Time& stamp) {
  configuration_ = configuration;
  bag_ = std::move(bag);
  finished_.reset();
  last_.reset();
  summary_ = summaryMessage(configuration_, std::nullopt, ros::Time());
  summary_topic_.publish(summary_);
  picture_ = std::move(picture);
  fixed_frames_.sendTransform(picture_->frames());
  if (bag_) {
    tf2_msgs::TFMessage frames;
    frames.transforms = picture_->frames();
    bag_->write(frames, stamp);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  scene_ = picture_->scene();
  update_ = {};
  episodes_.clear();
  curve_.clear();
  curve_is_whole_ = false;
  state_ = RunState::kRuns;
  caption_ = "policy " + configuration_.policy + ", no step yet";
  markers_.publish(scene_);
  drawState();
}

void Broadcast::showState(RunState state, const std::string& words) {
  const std::lock_guard<std::mutex> lock(mutex_);
  state_ = state;
  words_ = words;
  drawState();
}

void Broadcast::showPaused(bool paused) {
  const std::lock_guard<std::mutex> lock(mutex_);
  paused_ = paused;
  drawState();
}

/// Draws the line of the state. The caller holds the mutex.
void Broadcast::drawState() {
  if (state_ != RunState::kRuns) {
    state_markers_ = stateMarkers(state_, words_);
  } else if (paused_) {
    state_markers_ = stateMarkers(RunState::kPaused, "paused: " + caption_);
  } else {
    state_markers_ = stateMarkers(RunState::kRuns, caption_);
  }
  markers_.publish(state_markers_);
}

void Broadcast::restore(const std::vector<EpisodeResult>& results, const Summary& finished, std::optional<int> last,
                        const ros::Time& stamp) {
  finished_ = finished;
  last_ = last;
  summary_ = summaryMessage(configuration_, finished_, stamp);
  summary_topic_.publish(summary_);
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const EpisodeResult& result : results) {
    episodes_.push_back(toMessage(configuration_.protocol, result, stamp));
  }
}

pusht_msgs::Divergence Broadcast::step(const Episode& episode, const ros::Time& stamp, bool paced) {
  const std::pair<int, int> last = std::exchange(published_, {episode.index(), episode.steps()});
  stamp_ = stamp;
  if (!curve_is_whole_ && last != std::pair(episode.index(), episode.steps() - 1)) {
    for (int before = 0; before < episode.steps(); ++before) {
      const pusht_msgs::Divergence missed = divergenceMessage(episode, before, stamp);
      appendToCurve(missed);
      divergence_.publish(missed);
    }
  }
  pusht_msgs::Divergence divergence = divergenceMessage(episode, episode.steps(), stamp);
  appendToCurve(divergence);
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

void Broadcast::appendToCurve(const pusht_msgs::Divergence& divergence) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (curve_is_whole_) {
    return;
  }
  if (divergence.step == 0) {
    curve_.clear();
  }
  curve_.push_back(divergence);
}

void Broadcast::publishWholeCurve(const Episode& whole, const ros::Time& stamp) {
  std::vector<pusht_msgs::Divergence> curve;
  for (int step = 0; step <= whole.steps(); ++step) {
    curve.push_back(divergenceMessage(whole, step, stamp));
    divergence_.publish(curve.back());
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  curve_is_whole_ = true;
  curve_ = std::move(curve);
}

void Broadcast::redrawLastStep(const Episode& episode) {
  if (drawn_ != published_ && episode.index() == published_.first) {
    draw(truncatedEpisode(configuration_.protocol, episode, published_.second), stamp_, false);
  }
}

void Broadcast::draw(const Episode& episode, const ros::Time& stamp, bool recorded) {
  drawn_ = {episode.index(), episode.steps()};
  const std::string& headline = summary_.headline;
  const MarkerArray update = picture_->update(configuration_, episode, finished_, headline);
  if (bag_ && recorded) {
    bag_->write(scene_, stamp);  // again: a player may begin anywhere
    bag_->write(update, stamp);
  }
  const MarkerArray overlay = picture_->overlay(configuration_, episode, headline);
  const std::lock_guard<std::mutex> lock(mutex_);
  update_ = update;
  update_.markers.insert(update_.markers.end(), overlay.markers.begin(), overlay.markers.end());
  markers_.publish(update_);
  const bool at_end = finished_ && last_ == episode.index() && episode.finished();  // a replay may be elsewhere
  state_ = at_end ? RunState::kFinished : RunState::kRuns;
  caption_ = progressCaption(configuration_, episode);
  words_ = at_end
               ? "finished: policy " + configuration_.policy + ", " + std::to_string(finished_->episodes) + " episodes"
               : "";
  drawState();
}

bool Broadcast::onEpisodes(pusht_msgs::EpisodesRequest& /*request*/, pusht_msgs::EpisodesResponse& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  response.episodes = episodes_;
  response.curve = curve_;
  return true;
}

void Broadcast::republish() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  markers_.publish(scene_);
  markers_.publish(update_);
  markers_.publish(state_markers_);
}

void Broadcast::finish(const Episode& episode, const EpisodeResult& result, const Summary& finished, bool last,
                       const ros::Time& stamp) {
  finished_ = finished;
  if (last) {
    last_ = episode.index();
  }
  summary_ = summaryMessage(configuration_, finished_, stamp);
  const Protocol& protocol = configuration_.protocol;
  const pusht_msgs::EpisodeResult message = toMessage(protocol, result, stamp);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    episodes_.push_back(message);
  }
  for (const pusht_msgs::Trace& trace : traceMessages(protocol, episode, stamp)) {
    trace_.publish(trace);
    if (bag_) {
      bag_->write(trace);
    }
  }
  episode_.publish(message);
  summary_topic_.publish(summary_);
  if (bag_) {
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
