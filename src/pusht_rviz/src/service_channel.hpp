// SPDX-License-Identifier: BSD-3-Clause
/// Asynchronous calls of one service over a persistent connection, in a thread of their own.
///
/// pusht::ServiceCaller, with its Watchdog, is for callers that wait: it blocks until the answer and throws if there is
/// none. A GUI can do neither, and wants to know of a node's end between calls too.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <thread>

namespace pusht_rviz {

/// State of the node at the other end.
enum class Presence {
  kWaiting,  ///< it has not answered yet
  kAlive,    ///< it has answered the last call, and the connection stands
  kSilent,   ///< a call has been under way for longer than Times::silence: it hangs, or works for long
  kLost,     ///< it was there, and the connection has closed
};

/// Connection that a channel calls over.
class Connection {
 public:
  Connection() = default;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  virtual ~Connection() = default;

  /// Whether it stands. It ends when the other end closes it, which the end of a process does at once. Only a call
  /// that was answered proves that it ever stood.
  virtual bool stands() const = 0;

  /// Closes it, so that a call under way returns. Called from another thread than the call.
  virtual void close() = 0;
};

/// Thread that calls a service, reconnects, and follows the presence of the node that serves it. All methods belong to
/// one thread, that of the owner. None of them waits, except the destructor.
class ServiceChannel {
 public:
  using Clock = std::chrono::steady_clock;

  /// Makes a connection, whether it stands or not. Called in the channel's thread.
  using Connect = std::function<std::shared_ptr<Connection>()>;
  /// Makes one call. False: there was no answer, and the channel reconnects. Called in the channel's thread, which may
  /// outlive the channel: it must own, or share, what it uses.
  using Call = std::function<bool(Connection&)>;
  /// Called after each change of presence, in the channel's thread or in that of attend().
  using Tell = std::function<void(Presence)>;

  /// Periods and deadlines of the connection.
  struct Times {
    std::chrono::milliseconds tick{100};        ///< period at which the connection is looked at
    std::chrono::milliseconds heartbeat{1000};  ///< period of the heartbeat
    std::chrono::milliseconds retry{500};       ///< period of attempts to connect
    std::chrono::milliseconds silence{1500};    ///< duration of a call after which the node counts as silent
    std::chrono::milliseconds deadline{5000};   ///< duration of a call after which it is broken off
    std::chrono::milliseconds farewell{300};    ///< longest that the destructor waits for the thread
  };

  /// `heartbeat` is the call that shows between other calls that the node still answers.
  ServiceChannel(Connect connect, Call heartbeat, Tell tell, const Times& times);
  ServiceChannel(Connect connect, Call heartbeat, Tell tell) : ServiceChannel(connect, heartbeat, tell, Times()) {}
  ServiceChannel(const ServiceChannel&) = delete;
  ServiceChannel& operator=(const ServiceChannel&) = delete;

  /// Breaks off the call under way, and waits for the thread for Times::farewell at most. A thread that still hangs
  /// then, in a call to a master that hangs, is left behind and ends by itself.
  ~ServiceChannel();

  /// Takes no more calls. Several channels end at the same time if end() is called on all before one is destroyed.
  void end();

  /// Queues a call. Without a connection it fails at once.
  void ask(Call call);

  /// Checks the duration of the call under way: it tells of silence, and breaks the call off at its deadline. The owner
  /// calls it more often than Times::silence.
  void attend();

 private:
  struct State;
  static void run(const std::shared_ptr<State>& state);

  std::shared_ptr<State> state_;
  std::thread thread_;
};

}  // namespace pusht_rviz
