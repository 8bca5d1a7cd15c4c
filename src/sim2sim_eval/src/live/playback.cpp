// SPDX-License-Identifier: BSD-3-Clause
#include "live/playback.hpp"

#include <pusht_msgs/Nodes.h>
#include <ros/ros.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>

#include "live/control.hpp"
#include "live/request.hpp"
#include "live/truncated_episode.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/run.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_serving/node.hpp"
#include "sim2sim_serving/transforms.hpp"

namespace sim2sim {
namespace {

/// The episode with which the run ended; none if it was ended before it was whole.
std::optional<int> lastOf(const RecordedRun& run) {
  return isWhole(run.configuration, run.episodes) ? std::optional<int>(run.episodes.back().index) : std::nullopt;
}

RecordedRun read(const std::string& bag, std::map<int, Episode>& episodes) {
  if (bag.empty()) {
    throw pusht::InvalidInput("no bag: say which, as bag:=PATH of a compare.bag");
  }
  RecordedRun run = readRun(
      bag, [] { return !ros::ok() || interrupted(); },
      [&](Episode&& episode) { episodes.emplace(episode.index(), std::move(episode)); });
  if (episodes.empty()) {
    throw pusht::InvalidInput("bag " + bag + ": must hold a finished episode");
  }
  return run;
}

int stepsIn(double seconds) { return static_cast<int>(std::lround(seconds / pusht::kControlStep)); }

}  // namespace

PlaybackParameters PlaybackParameters::load(pusht::ParameterReader& parameters) {
  PlaybackParameters loaded;
  loaded.bag = parameters.text("bag", "");
  const int episode = parameters.integer("episode", -1);
  if (episode >= 0) {
    loaded.episode = episode;
  }
  loaded.start = parameters.real("start", loaded.start);
  if (!(loaded.start >= 0.0 && loaded.start <= pusht::kHorizon * pusht::kControlStep)) {
    throw pusht::InvalidInput("start " + pusht::shortestText(loaded.start) + ": must be within an episode [s]");
  }
  loaded.speed = parameters.real("speed", loaded.speed);
  if (!(std::isfinite(loaded.speed) && loaded.speed >= 0.0)) {
    throw pusht::InvalidInput("speed " + pusht::shortestText(loaded.speed) +
                              ": must be finite and >= 0 (times real time; 0: as fast as possible)");
  }
  return loaded;
}

Playback::Playback(const ros::NodeHandle& node, const PlaybackParameters& parameters)
    : node_(node),
      run_(read(parameters.bag, episodes_)),
      frame_prefixes_{"reference", "engine", "engine_replay"},
      broadcast_(node_),
      progress_(node_.advertise<pusht_msgs::Progress>("progress", 1, true)),
      request_(node_.advertise<pusht_msgs::CompareGoal>("request", 1, true)),
      nodes_(node_.advertise<pusht_msgs::Nodes>("nodes", 1)) {
  pusht_msgs::ControlRequest start;
  start.episode = static_cast<std::uint64_t>(parameters.episode.value_or(episodes_.begin()->first));
  const PlaybackPosition begin = positionOf(start);
  sought_ = PlaybackPosition{begin.episode, std::min(stepsIn(parameters.start), episodes_.at(begin.episode).steps())};
  pacer_.setRate(parameters.speed / pusht::kControlStep);
  const RunConfiguration& configuration = run_.configuration;
  request_.publish(goalOf(configuration.protocol));
  broadcast_.begin(configuration, Picture::of(configuration, frame_prefixes_), nullptr, stamp_);
  broadcast_.restore(run_.episodes, summarize(configuration.protocol, run_.episodes), lastOf(run_), stamp_);
  control_ = node_.advertiseService("control", &Playback::onControl, this);
  repeating_ = node_.createSteadyTimer(ros::WallDuration(1.0), [this](const ros::SteadyTimerEvent&) { republish(); });
  heart_ = node_.createSteadyTimer(ros::WallDuration(0.25),
                                   [this](const ros::SteadyTimerEvent&) { nodes_.publish(pusht_msgs::Nodes()); });
  publishProgress();
}

void Playback::run() {
  waitForAudience();
  while (!ended()) {
    if (const std::optional<PlaybackPosition> position = takeSought()) {
      show(*position);
    } else if (pacer_.wait([this] { return ended() || sought(); })) {
      advance();
    }
  }
}

void Playback::waitForAudience() const {
  constexpr double kLookPeriod = 0.05;  // [s]
  while (!ended() && !broadcast_.watched()) {
    ros::WallDuration(kLookPeriod).sleep();
  }
}

void Playback::advance() {
  const auto whole = episodes_.find(shown_->index());
  if (shown_->steps() < whole->second.steps()) {
    show({shown_->index(), shown_->steps() + 1});
  } else if (std::next(whole) != episodes_.end()) {
    show({std::next(whole)->first, 0});
  } else {
    at_end_ = true;
    pacer_.pause();
    publishProgress();
  }
}

void Playback::show(const PlaybackPosition& position) {
  const bool another = !shown_ || shown_->index() != position.episode;
  shown_ = truncatedEpisode(run_.configuration.protocol, episodes_.at(position.episode), position.step);
  stamp_ += ros::Duration(pusht::kControlStep);
  if (another) {
    broadcast_.publishWholeCurve(episodes_.at(position.episode), stamp_);
  }
  std::vector<geometry_msgs::TransformStamped> frames;
  for (const Mode mode : kModes) {
    const pusht::WorldState& state = shown_->rollout(mode).trace().states.back();
    for (const auto& frame : pusht::movingFrames(frame_prefixes_.at(mode), state, stamp_)) {
      frames.push_back(frame);
    }
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    moving_ = std::move(frames);
    frames_.sendTransform(moving_);
  }
  broadcast_.step(*shown_, stamp_, true);
}

/// Sends the last frames again, for late subscribers and after rviz's Reset. Stamps grow, because tf2 warns of one that
/// comes twice.
void Playback::republish() {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (geometry_msgs::TransformStamped& frame : moving_) {
    frame.header.stamp += ros::Duration(0, 1);
  }
  frames_.sendTransform(moving_);
}

bool Playback::ended() const { return !ros::ok() || interrupted(); }

std::optional<Playback::PlaybackPosition> Playback::takeSought() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(sought_, std::nullopt);
}

bool Playback::sought() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return sought_.has_value();
}

Playback::PlaybackPosition Playback::positionOf(const pusht_msgs::ControlRequest& request) const {
  const auto held = std::find_if(episodes_.begin(), episodes_.end(), [&](const auto& episode) {
    return static_cast<std::uint64_t>(episode.first) == request.episode;
  });
  if (held == episodes_.end()) {
    throw pusht::InvalidInput("episode " + std::to_string(request.episode) +
                              ": must be one that the bag holds: " + std::to_string(episodes_.begin()->first) + " to " +
                              std::to_string(episodes_.rbegin()->first));
  }
  const auto last = static_cast<std::uint32_t>(held->second.steps());
  if (request.step > last) {
    throw pusht::InvalidInput("step " + std::to_string(request.step) + ": must be from 0 to " + std::to_string(last) +
                              ", the end of episode " + std::to_string(request.episode));
  }
  return {held->first, static_cast<int>(request.step)};
}

bool Playback::onControl(pusht_msgs::ControlRequest& request, pusht_msgs::ControlResponse& response) {
  response = controlResponse([&] {
    if (request.command == pusht_msgs::ControlRequest::SEEK) {
      seek(positionOf(request));
    } else {
      if (request.command == pusht_msgs::ControlRequest::RESUME && at_end_) {
        seek({episodes_.begin()->first, 0});  // once more
      }
      applyControl(pacer_, request);
    }
    publishProgress();
  });
  return true;
}

void Playback::seek(const PlaybackPosition& position) {
  at_end_ = false;
  const std::lock_guard<std::mutex> lock(mutex_);
  sought_ = position;
}

void Playback::publishProgress() {
  const std::lock_guard<std::mutex> publishing(publishing_);
  pusht_msgs::Progress progress;
  progress.replay = 1;
  progress.paused = static_cast<std::uint8_t>(pacer_.paused());
  progress.rate = pacer_.rate();
  progress.episodes = static_cast<std::uint32_t>(run_.configuration.protocol.episodes);
  progress.episodes_finished = static_cast<std::uint32_t>(episodes_.size());
  progress.seconds_left = std::numeric_limits<double>::quiet_NaN();
  progress_.publish(progress);
  broadcast_.showPaused(pacer_.paused());
}

pusht::ExitCode servePlayback() {
  pusht::requireClock();
  const ros::NodeHandle node("~");
  pusht::ParameterReader parameters(node);
  parameters.enterWorkingDirectory();
  const PlaybackParameters loaded = PlaybackParameters::load(parameters);
  parameters.refuseUnknown();
  Playback playback(node, loaded);
  ros::AsyncSpinner callbacks(1);
  callbacks.start();
  playback.run();
  return pusht::ExitCode::kOk;
}

}  // namespace sim2sim
