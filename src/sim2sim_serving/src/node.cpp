// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/node.hpp"

#include <ros/ros.h>
#include <ros/xmlrpc_manager.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/uuid/random_generator.hpp>
#include <boost/uuid/uuid_io.hpp>
#include <cctype>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <iostream>
#include <mutex>
#include <thread>

#include "pusht_task/clipped.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/reason.hpp"
#include "pusht_task/standard_streams.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace pusht {
namespace {

constexpr std::chrono::seconds kWatchPeriod{1};
constexpr int kMasterPatience = 3;      // checks in a row that fail
constexpr double kClockPatience = 5.0;  // [s]

/// roscpp's poll thread is woken by every message that another thread begins to send, and spins until it is sent. As it
/// usually preempts the very thread that sends, both wait for the scheduler. Batch threads do not preempt: on two cores
/// a run over five nodes takes a third of the time. Inherited by the threads that are started from here on.
void schedulePatiently() {
  const sched_param none{};
  sched_setscheduler(0, SCHED_BATCH, &none);  // only speed depends on it: whether it is allowed does not matter
}

void requireMaster(NoMaster no_master) {
  if (no_master == NoMaster::kWait) {
    XmlRpc::XmlRpcValue arguments;
    XmlRpc::XmlRpcValue result;
    XmlRpc::XmlRpcValue payload;
    arguments[0] = ros::this_node::getName();
    ros::master::execute("getPid", arguments, result, payload, true);
    return;
  }
  if (!ros::master::check()) {
    throw RuntimeFault("no ROS master at " + ros::master::getURI() + ": start roscore, or use roslaunch");
  }
}

/// roslaunch names a log file to every node that it starts.
bool startedByRoslaunch(int argc, char** argv) {
  return std::any_of(argv, argv + argc, [](const std::string& argument) { return argument.rfind("__log:=", 0) == 0; });
}

/// Removes private parameters at its end: the next node of this name would get them. One that roslaunch may start again
/// needs them.
class Removal {
 public:
  Removal(Life life, bool started_by_roslaunch) : life_(life), started_by_roslaunch_(started_by_roslaunch) {}
  Removal(const Removal&) = delete;
  Removal& operator=(const Removal&) = delete;
  ~Removal() {
    try {
      if (isReplaced()) {
        return;  // they are the other node's now
      }
      if (!started_by_roslaunch_) {
        removeOwnParameters();
      } else if (life_ == Life::kRunsOnce) {
        ros::param::del("~");
      }
    } catch (const std::exception& failure) {
      ROS_WARN_STREAM("parameters stay on the parameter server: " << failure.what());
    }
  }

 private:
  /// Whether a second node of this name has registered.
  static bool isReplaced() {
    XmlRpc::XmlRpcValue arguments;
    XmlRpc::XmlRpcValue result;
    XmlRpc::XmlRpcValue uri;
    arguments[0] = ros::this_node::getName();
    arguments[1] = ros::this_node::getName();
    return ros::master::execute("lookupNode", arguments, result, uri, false) &&
           uri.getType() == XmlRpc::XmlRpcValue::TypeString &&
           static_cast<std::string>(uri) != ros::XMLRPCManager::instance()->getServerURI();
  }

  Life life_;
  bool started_by_roslaunch_;
};

/// Shuts the node down when the master has died, or the roslaunch that has started the node: it would live on without
/// being found, or ended, by anyone.
class Watch {
 public:
  explicit Watch(bool started_by_roslaunch)
      : parent_(started_by_roslaunch ? ::getppid() : 0), thread_([this] { watch(); }) {}
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;
  ~Watch() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ending_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }

  /// Throws RuntimeFault if it has shut the node down.
  void requireNothingLost() const {
    if (master_lost_) {
      throw RuntimeFault("the ROS master at " + ros::master::getURI() + " has died");
    }
    if (launch_lost_) {
      throw RuntimeFault("roslaunch, which has started this node, has died");
    }
  }

 private:
  void watch() {
    int failures = 0;
    std::unique_lock<std::mutex> lock(mutex_);
    while (!wake_.wait_for(lock, kWatchPeriod, [this] { return ending_; }) && ros::ok()) {
      failures = ros::master::check() ? 0 : failures + 1;
      master_lost_ = failures == kMasterPatience;
      launch_lost_ = parent_ != 0 && ::getppid() != parent_;
      if (master_lost_ || launch_lost_) {
        ros::requestShutdown();
        return;
      }
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  bool ending_ = false;
  std::atomic<bool> master_lost_{false};
  std::atomic<bool> launch_lost_{false};
  const pid_t parent_;  // 0: anyone
  std::thread thread_;
};

}  // namespace

int runNode(int argc, char** argv, const std::string& name, NoMaster no_master, const std::function<ExitCode()>& body,
            Life life) {
  openStandardStreams();
  try {
    // init() takes such arguments away.
    const bool started_by_roslaunch = startedByRoslaunch(argc, argv);
    takeCommandLine(argc, argv);
    schedulePatiently();
    const std::uint32_t catches_signals = ros::init_options::NoSigintHandler;
    ros::init(argc, argv, name, life == Life::kRunsOnce ? catches_signals : 0);
    requireMaster(no_master);
    const ros::NodeHandle keeps_node_started;
    const Removal removal(life, started_by_roslaunch);
    const Watch watch(started_by_roslaunch);
    const ExitCode code = body();
    watch.requireNothingLost();
    return static_cast<int>(code);
  } catch (const std::exception& failure) {
    return reportFailure(name, failure);
  }
}

void becomeNode() {
  if (!ros::isInitialized()) {
    schedulePatiently();
    ros::init(ros::M_string(), "sim2sim",
              ros::init_options::AnonymousName | ros::init_options::NoSigintHandler | ros::init_options::NoRosout);
  }
  requireMaster(NoMaster::kFail);
  static const ros::NodeHandle keeps_node_started;
}

void requireClock() {
  if (ros::param::param("/use_sim_time", false) && !ros::Time::waitForValid(ros::WallDuration(kClockPatience))) {
    throw RuntimeFault(
        "/use_sim_time is set, but nothing publishes /clock: unset it, or start what publishes the clock");
  }
}

int reportFailure(const std::string& reporter, const std::exception& failure) {
  std::string message = clipped(reasonOf(failure));
  std::replace_if(
      message.begin(), message.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
  std::cerr << reporter + ": " + message + "\n" << std::flush;  // at once: other processes write there too
  return static_cast<int>(exitCodeOf(failure));
}

std::string newInstanceId() { return to_string(boost::uuids::random_generator()()); }

}  // namespace pusht
