// SPDX-License-Identifier: BSD-3-Clause
#include "evaluator_client.hpp"

#include <actionlib/client/action_client.h>
#include <pusht_msgs/CompareAction.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <ros/subscriber.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace pusht_rviz {
namespace {

using Client = actionlib::ActionClient<pusht_msgs::CompareAction>;

constexpr std::chrono::milliseconds kFarewell{300};
constexpr std::chrono::milliseconds kLook{200};  // period at which the client looks whether the action is served

constexpr std::uint32_t kManySteps = 10'000;  // at full speed some hundreds come in a second; none may be dropped
constexpr std::uint32_t kManyEpisodes = 1'000;

/// Event of a goal's state; none in between. A rejected goal reports its end when its result has come.
std::optional<GoalEvent> eventOf(const Client::GoalHandle& goal) {
  const actionlib::CommState state = goal.getCommState();
  if (state == actionlib::CommState::ACTIVE) {
    return GoalEvent{};
  }
  if (state != actionlib::CommState::DONE) {
    return std::nullopt;
  }
  const actionlib::TerminalState end = goal.getTerminalState();
  return GoalEvent{true, end == actionlib::TerminalState::REJECTED, end.getText()};
}

}  // namespace

/// State shared with the thread, which may outlive the client.
struct EvaluatorClient::State {
  std::string evaluator;
  std::shared_ptr<Events> events;
  ros::CallbackQueue queue;

  std::mutex mutex;  // guards all members below
  std::condition_variable changed;
  bool ending = false;
  bool ended = false;
  std::shared_ptr<Client> client;  // set once all topics are subscribed
  Client::GoalHandle goal;         // the last one that was sent

  bool waitForEnd(std::chrono::milliseconds period) {
    std::unique_lock<std::mutex> lock(mutex);
    return changed.wait_for(lock, period, [this] { return ending; });
  }
};

EvaluatorClient::EvaluatorClient(std::string evaluator, std::shared_ptr<Events> events)
    : state_(std::make_shared<State>()) {
  state_->evaluator = std::move(evaluator);
  state_->events = std::move(events);
  thread_ = std::thread([state = state_] { run(state); });
}

void EvaluatorClient::end() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->ending = true;
  state_->changed.notify_all();
}

EvaluatorClient::~EvaluatorClient() {
  end();
  std::unique_lock<std::mutex> lock(state_->mutex);
  const bool ended = state_->changed.wait_for(lock, kFarewell, [this] { return state_->ended; });
  lock.unlock();
  if (ended) {
    thread_.join();
  } else {
    thread_.detach();
  }
}

bool EvaluatorClient::send(const pusht_msgs::CompareGoal& goal) {
  std::shared_ptr<Client> client;
  {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    client = state_->client;
  }
  if (!client || !client->isServerConnected()) {
    return false;
  }
  // The callback may come when the client has gone, so it shares the events alone.
  const auto handle = client->sendGoal(goal, [events = state_->events](const Client::GoalHandle& changed) {
    if (const std::optional<GoalEvent> event = eventOf(changed)) {
      events->push(*event);
    }
  });
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->goal = handle;
  return true;
}

void EvaluatorClient::run(const std::shared_ptr<State>& state) {
  ros::NodeHandle node(state->evaluator);
  node.setCallbackQueue(&state->queue);
  ros::AsyncSpinner spinner(1, &state->queue);
  spinner.start();
  const std::shared_ptr<Events> events = state->events;
  std::vector<ros::Subscriber> subscribers;
  const auto subscribe = [&](const char* topic, std::uint32_t depth, auto example) {
    using Message = decltype(example);
    subscribers.push_back(node.subscribe<Message>(
        topic, depth, [events](const boost::shared_ptr<Message const>& message) { events->push(*message); }));
  };
  subscribe("progress", kManyEpisodes, pusht_msgs::Progress());
  subscribe("request", 1, pusht_msgs::CompareGoal());
  subscribe("options", 1, pusht_msgs::RunOptions());
  subscribe("summary", 1, pusht_msgs::Summary());
  subscribe("episode", kManyEpisodes, pusht_msgs::EpisodeResult());
  subscribe("divergence", kManySteps, pusht_msgs::Divergence());
  auto client = std::make_shared<Client>(node, "compare", &state->queue);
  {
    const std::lock_guard<std::mutex> lock(state->mutex);
    state->client = client;
  }
  bool served = false;
  while (!state->waitForEnd(kLook)) {
    if (std::exchange(served, client->isServerConnected()) != served) {
      events->push(ActionEvent{served});
    }
  }
  state->queue.disable();
  spinner.stop();
  {
    const std::lock_guard<std::mutex> lock(state->mutex);
    state->goal.reset();
    state->client.reset();
  }
  subscribers.clear();
  client.reset();
  state->queue.clear();
  const std::lock_guard<std::mutex> lock(state->mutex);
  state->ended = true;
  state->changed.notify_all();
}

}  // namespace pusht_rviz
