// SPDX-License-Identifier: BSD-3-Clause
#include "service_channel.hpp"

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace pusht_rviz {

/// State shared with the thread, which may outlive the channel.
struct ServiceChannel::State {
  Connect connect;
  Call heartbeat;
  Tell tell;
  Times times;

  std::mutex mutex;  // guards all members below
  std::condition_variable changed;
  std::deque<Call> calls;
  bool ending = false;
  Clock::time_point end;  // time at which `ending` was set
  bool ended = false;
  bool broken_off = false;  // the call under way has reached its deadline
  std::shared_ptr<Connection> connection;
  std::optional<Clock::time_point> calling_since;
  Presence presence = Presence::kWaiting;

  bool stands() {
    const std::lock_guard<std::mutex> lock(mutex);
    return connection && connection->stands();
  }

  /// Changes the presence and tells it. The caller must not hold `mutex`.
  void become(Presence now) {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      // A node that was never there cannot be lost.
      if (ending || now == presence || (now == Presence::kLost && presence == Presence::kWaiting)) {
        return;
      }
      presence = now;
    }
    tell(now);
  }

  /// Makes one call and derives the presence from its outcome.
  void call(const Call& one) {
    std::shared_ptr<Connection> over;
    {
      const std::lock_guard<std::mutex> lock(mutex);
      if (ending) {
        return;
      }
      over = connection;
      broken_off = false;
      calling_since = Clock::now();
    }
    const bool answered = one(*over);
    bool hangs = false;
    {
      const std::lock_guard<std::mutex> lock(mutex);
      calling_since.reset();
      hangs = broken_off;
    }
    if (answered) {
      become(Presence::kAlive);
    } else if (!hangs) {
      // Closed by hand: a roscpp client whose connection was refused before it began to listen for that stays valid.
      over->close();
      become(Presence::kLost);
    }
  }
};

ServiceChannel::ServiceChannel(Connect connect, Call heartbeat, Tell tell, const Times& times)
    : state_(std::make_shared<State>()) {
  state_->connect = std::move(connect);
  state_->heartbeat = std::move(heartbeat);
  state_->tell = std::move(tell);
  state_->times = times;
  thread_ = std::thread([state = state_] { run(state); });
}

void ServiceChannel::end() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  if (!std::exchange(state_->ending, true)) {
    state_->end = Clock::now();
    state_->changed.notify_all();
  }
}

ServiceChannel::~ServiceChannel() {
  end();
  std::unique_lock<std::mutex> lock(state_->mutex);
  const auto ended = [this] { return state_->ended; };
  // The wait comes first because roscpp cannot break off a call in its first moments. A call that is still under way
  // after it can be broken off.
  if (!state_->changed.wait_until(lock, state_->end + state_->times.farewell / 3, ended) && state_->connection) {
    const std::shared_ptr<Connection> connection = state_->connection;
    lock.unlock();
    connection->close();
    lock.lock();
  }
  const bool joinable = state_->changed.wait_until(lock, state_->end + state_->times.farewell, ended);
  lock.unlock();
  if (joinable) {
    thread_.join();
  } else {
    thread_.detach();
  }
}

void ServiceChannel::ask(Call call) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->calls.push_back(std::move(call));
  state_->changed.notify_all();
}

void ServiceChannel::attend() {
  std::shared_ptr<Connection> overdue;
  {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    if (!state_->calling_since || Clock::now() - *state_->calling_since < state_->times.silence) {
      return;
    }
    if (Clock::now() - *state_->calling_since >= state_->times.deadline && !state_->broken_off) {
      state_->broken_off = true;
      overdue = state_->connection;
    }
  }
  state_->become(Presence::kSilent);
  if (overdue) {
    overdue->close();
  }
}

void ServiceChannel::run(const std::shared_ptr<State>& state) {
  Clock::time_point next_heartbeat = Clock::now();
  Clock::time_point next_attempt = next_heartbeat;
  std::unique_lock<std::mutex> lock(state->mutex);
  while (!state->ending) {
    std::optional<Call> asked;
    if (!state->calls.empty()) {
      asked = std::move(state->calls.front());
      state->calls.pop_front();
    }
    lock.unlock();
    if (!state->stands()) {
      bool broken_off = false;
      {
        const std::lock_guard<std::mutex> look(state->mutex);
        broken_off = std::exchange(state->broken_off, false);
      }
      if (!broken_off) {
        state->become(Presence::kLost);
      }
      if (asked || Clock::now() >= next_attempt) {
        std::shared_ptr<Connection> connection = state->connect();
        const std::lock_guard<std::mutex> keep(state->mutex);
        state->connection = std::move(connection);
        next_attempt = Clock::now() + state->times.retry;
        next_heartbeat = Clock::now();
      }
    }
    if (asked) {
      state->call(*asked);
    } else if (Clock::now() >= next_heartbeat && state->stands()) {
      state->call(state->heartbeat);
      next_heartbeat = Clock::now() + state->times.heartbeat;
    }
    lock.lock();
    state->changed.wait_for(lock, state->times.tick, [&] { return state->ending || !state->calls.empty(); });
  }
  state->ended = true;
  state->changed.notify_all();
}

}  // namespace pusht_rviz
