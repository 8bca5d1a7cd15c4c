// SPDX-License-Identifier: BSD-3-Clause
/// A persistent connection to one service of one node, and a thread of its own for the calls: a node that hangs holds
/// up nobody else.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <thread>

namespace pusht_rviz {

/// What is known of who serves.
enum class Presence {
  kWaiting,  ///< nobody has answered yet
  kAlive,    ///< the last call was answered, and the connection stands
  kSilent,   ///< a call is not answered for long: the node hangs, or does something long
  kLost,     ///< it was there, and the connection has closed
};

/// What a line goes over.
class Connection {
 public:
  Connection() = default;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  virtual ~Connection() = default;

  /// Whether it stands; false from when the other end closes it, which the end of its process does at once. Only a call
  /// that was answered shows that it ever stood.
  virtual bool stands() const = 0;

  /// Closes it, so that a call under way returns. Called from another thread than the call's.
  virtual void close() = 0;
};

/// All of its methods may be called in any one thread, and none of them waits; but see ~Line().
class Line {
 public:
  using Clock = std::chrono::steady_clock;

  /// Makes a connection; it may stand or not. Called in the line's thread.
  using Connect = std::function<std::shared_ptr<Connection>()>;
  /// One call; false: there was no answer, so the connection is made anew. Called in the line's thread. It must not
  /// touch what may be gone by then.
  using Call = std::function<bool(Connection&)>;
  /// Called in the line's thread, or in that of attend(), whenever the presence has changed.
  using Tell = std::function<void(Presence)>;

  /// Periods and deadlines of the connection.
  struct Times {
    std::chrono::milliseconds tick{100};        ///< how often the connection is looked at
    std::chrono::milliseconds heartbeat{1000};  ///< from one heartbeat to the next
    std::chrono::milliseconds retry{500};       ///< from one attempt to connect to the next
    std::chrono::milliseconds silence{1500};    ///< a call that takes longer is worth a word
    std::chrono::milliseconds deadline{5000};   ///< a call that takes longer is broken off
    std::chrono::milliseconds farewell{300};    ///< how long the destructor waits for the thread
  };

  /// `heartbeat` is called once in a while, to know that the other end still answers.
  Line(Connect connect, Call heartbeat, Tell tell, const Times& times);
  Line(Connect connect, Call heartbeat, Tell tell) : Line(connect, heartbeat, tell, Times()) {}
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  /// Breaks off what is under way. A thread that hangs all the same, in a call to a master that hangs, is left behind.
  ~Line();

  /// Takes no more calls. Before the destructor, so that several lines end at the same time.
  void end();

  /// Calls in turn. Without a connection the call is made over one that does not stand, and fails at once.
  void ask(Call call);

  /// Looks after deadlines; to be called often.
  void attend();

 private:
  struct State;
  static void run(const std::shared_ptr<State>& state);

  std::shared_ptr<State> state_;
  std::thread thread_;
};

}  // namespace pusht_rviz
