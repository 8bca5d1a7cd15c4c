// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_rviz/session.hpp"

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
constexpr std::chrono::milliseconds kLook{200};  // how often it is asked whether the action is served

constexpr std::uint32_t kManySteps = 10'000;  // at full speed some hundreds come in a second
constexpr std::uint32_t kManyEpisodes = 1'000;

/// None on the way: a goal that is rejected waits for its result, too.
std::optional<GoalNews> newsOf(const Client::GoalHandle& goal) {
  const actionlib::CommState state = goal.getCommState();
  if (state == actionlib::CommState::ACTIVE) {
    return GoalNews{};
  }
  if (state != actionlib::CommState::DONE) {
    return std::nullopt;
  }
  const actionlib::TerminalState end = goal.getTerminalState();
  return GoalNews{true, end == actionlib::TerminalState::REJECTED, end.getText()};
}

}  // namespace

/// Shared with the thread, which may outlive the session.
struct Session::State {
  std::string evaluator;
  std::shared_ptr<Post> post;
  ros::CallbackQueue queue;

  std::mutex mutex;  // of what follows
  std::condition_variable changed;
  bool ending = false;
  bool ended = false;
  std::shared_ptr<Client> client;  // once it is open
  Client::GoalHandle goal;         // ours, the last one

  bool waitForEnd(std::chrono::milliseconds period) {
    std::unique_lock<std::mutex> lock(mutex);
    return changed.wait_for(lock, period, [this] { return ending; });
  }
};

Session::Session(std::string evaluator, std::shared_ptr<Post> post) : state_(std::make_shared<State>()) {
  state_->evaluator = std::move(evaluator);
  state_->post = std::move(post);
  thread_ = std::thread([state = state_] { run(state); });
}

void Session::end() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->ending = true;
  state_->changed.notify_all();
}

Session::~Session() {
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

bool Session::send(const pusht_msgs::CompareGoal& goal) {
  std::shared_ptr<Client> client;
  {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    client = state_->client;
  }
  if (!client || !client->isServerConnected()) {
    return false;
  }
  // Of the whole state only what a callback may need when the session has gone.
  const auto handle = client->sendGoal(goal, [post = state_->post](const Client::GoalHandle& changed) {
    if (const std::optional<GoalNews> news = newsOf(changed)) {
      post->put(*news);
    }
  });
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->goal = handle;
  return true;
}

void Session::run(const std::shared_ptr<State>& state) {
  ros::NodeHandle node(state->evaluator);
  node.setCallbackQueue(&state->queue);
  ros::AsyncSpinner spinner(1, &state->queue);
  spinner.start();
  const std::shared_ptr<Post> post = state->post;
  std::vector<ros::Subscriber> subscribers;
  const auto subscribe = [&](const char* topic, std::uint32_t depth, auto example) {
    using Message = decltype(example);
    subscribers.push_back(node.subscribe<Message>(
        topic, depth, [post](const boost::shared_ptr<Message const>& message) { post->put(*message); }));
  };
  subscribe("progress", kManyEpisodes, pusht_msgs::Progress());
  subscribe("request", 1, pusht_msgs::CompareGoal());
  subscribe("summary", 1, pusht_msgs::Summary());
  subscribe("episode", kManyEpisodes, pusht_msgs::EpisodeResult());
  subscribe("divergence", kManySteps, pusht_msgs::Divergence());
  auto client = std::make_shared<Client>(node, "compare", &state->queue);
  {
    const std::lock_guard<std::mutex> lock(state->mutex);
    state->client = client;
  }
  post->put(SessionNews());
  bool served = false;
  while (!state->waitForEnd(kLook)) {
    if (std::exchange(served, client->isServerConnected()) != served) {
      post->put(ActionNews{served});
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
