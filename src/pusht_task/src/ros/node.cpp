// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/ros/node.hpp"

#include <ros/ros.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <boost/uuid/random_generator.hpp>
#include <boost/uuid/uuid_io.hpp>
#include <cctype>
#include <chrono>
#include <condition_variable>
#include <iostream>
#include <mutex>
#include <thread>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

constexpr std::chrono::seconds kMasterPeriod{1};
constexpr int kMasterPatience = 3;      // checks in a row that fail
constexpr double kClockPatience = 5.0;  // [s]

/// roscpp's poll thread is woken by every message that another thread begins to send, and spins until it is sent. As it
/// usually preempts the very thread that sends, both wait for the scheduler. Batch threads do not preempt: on two cores
/// a run over five nodes takes a third of the time. Inherited by the threads that are started from here on.
void schedulePatiently() {
  const sched_param none{};
  sched_setscheduler(0, SCHED_BATCH, &none);  // only speed depends on it: whether it is allowed does not matter
}

void requireMaster() {
  if (!ros::master::check()) {
    throw RuntimeFault("no ROS master at " + ros::master::getURI() + ": start roscore, or use roslaunch");
  }
}

void requireClock() {
  if (ros::param::param("/use_sim_time", false) && !ros::Time::waitForValid(ros::WallDuration(kClockPatience))) {
    throw RuntimeFault(
        "/use_sim_time is set, but nobody publishes /clock: unset it, or start what publishes the clock");
  }
}

/// Shuts the node down when the master has died: it would live on without being found by anyone.
class MasterWatch {
 public:
  MasterWatch() : thread_([this] { watch(); }) {}
  MasterWatch(const MasterWatch&) = delete;
  MasterWatch& operator=(const MasterWatch&) = delete;
  ~MasterWatch() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ending_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }

  bool lost() const { return lost_; }

 private:
  void watch() {
    int failures = 0;
    std::unique_lock<std::mutex> lock(mutex_);
    while (!wake_.wait_for(lock, kMasterPeriod, [this] { return ending_; }) && ros::ok()) {
      failures = ros::master::check() ? 0 : failures + 1;
      if (failures == kMasterPatience) {
        lost_ = true;
        ros::requestShutdown();
        return;
      }
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  bool ending_ = false;
  std::atomic<bool> lost_{false};
  std::thread thread_;
};

}  // namespace

int runNode(int argc, char** argv, const std::string& name, const std::function<ExitCode()>& body) {
  try {
    schedulePatiently();
    ros::init(argc, argv, name);
    requireMaster();
    const ros::NodeHandle keeps_node_started;
    requireClock();
    const MasterWatch master;
    const ExitCode code = body();
    if (master.lost()) {
      throw RuntimeFault("the ROS master at " + ros::master::getURI() + " has died");
    }
    return static_cast<int>(code);
  } catch (const std::exception& failure) {
    return reportFailure(name, failure);
  }
}

int reportFailure(const std::string& reporter, const std::exception& failure) {
  std::string message = failure.what();
  std::replace_if(
      message.begin(), message.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
  std::cerr << reporter + ": " + message + "\n" << std::flush;  // at once: other processes write there too
  return static_cast<int>(exitCodeOf(failure));
}

std::string newInstanceId() { return to_string(boost::uuids::random_generator()()); }

}  // namespace pusht
