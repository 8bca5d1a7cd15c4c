// SPDX-License-Identifier: BSD-3-Clause
/// Calls of services that can be interrupted.
#pragma once

#include <ros/node_handle.h>
#include <ros/service_client.h>

#include <mutex>
#include <string>

namespace pusht_rviz {

/// Connection to a service that stays. Only a call that was answered proves that it stands.
template <class Service>
ros::ServiceClient connectionTo(const std::string& service) {
  return ros::NodeHandle().serviceClient<Service>(service, true);
}

/// Calls of services, one at a time, that another thread may interrupt.
class ServiceCall {
 public:
  enum class Outcome { kAnswered, kFailed, kInterrupted };

  template <class Service>
  Outcome make(const ros::ServiceClient& client, Service& service) {
    ros::ServiceClient shared = client;  // the connection
    begin(shared);
    const bool answered = shared.isValid() && shared.call(service);
    const bool interrupted = end();
    return answered ? Outcome::kAnswered : interrupted ? Outcome::kInterrupted : Outcome::kFailed;
  }

  void interrupt() {
    const std::lock_guard<std::mutex> lock(mutex_);
    interrupted_ = true;
    under_way_.shutdown();
  }

 private:
  void begin(const ros::ServiceClient& client) {
    const std::lock_guard<std::mutex> lock(mutex_);
    under_way_ = client;
    interrupted_ = false;
  }

  /// Whether it was interrupted.
  bool end() {
    const std::lock_guard<std::mutex> lock(mutex_);
    under_way_ = {};
    return interrupted_;
  }

  std::mutex mutex_;  // guards the members below
  ros::ServiceClient under_way_;
  bool interrupted_ = false;
};

}  // namespace pusht_rviz
