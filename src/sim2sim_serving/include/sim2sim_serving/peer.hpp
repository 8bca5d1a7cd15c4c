// SPDX-License-Identifier: BSD-3-Clause
/// Calls to another node with a deadline: each ends with an answer or a fault.
#pragma once

#include <pusht_msgs/Describe.h>
#include <ros/init.h>
#include <ros/node_handle.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "pusht_task/error.hpp"

namespace pusht {

/// Error: a needed node is not there.
struct NodeMissing : RuntimeFault {
  explicit NodeMissing(const std::string& message, std::string services_of_it = "")
      : RuntimeFault(message), services(std::move(services_of_it)) {}

  std::string services;  ///< namespace of the node's services; empty: starting it again would not help
};

/// Error: a peer died, was replaced by another instance, or gave no answer in time. Its episode is lost.
struct PeerFault : NodeMissing {
  using NodeMissing::NodeMissing;
};

/// Deadline on the steady clock, for one call at a time. It has a thread of its own.
class Watchdog {
 public:
  explicit Watchdog(std::chrono::milliseconds deadline);
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;
  ~Watchdog();

  /// Runs `call`. If it has not returned by the deadline, `interrupt` is called, in another thread, to make it return.
  void run(const std::function<void()>& call, const std::function<void()>& interrupt);

  std::chrono::milliseconds deadline() const { return deadline_; }

 private:
  void watch();

  const std::chrono::milliseconds deadline_;
  std::mutex mutex_;
  std::condition_variable ending_changed_;
  bool ending_ = false;
  const std::function<void()>* interrupt_ = nullptr;  // interrupts the call under way
  std::chrono::steady_clock::time_point expiry_;      // deadline of that call
  std::thread thread_;
};

/// Node that serves a simulator or a policy, seen by a caller. Not thread-safe: peers that share a watchdog belong to
/// one thread.
class Peer {
 public:
  /// `services` is the namespace of its services, e.g. "/engine". The watchdog must outlive the peer.
  Peer(std::string services, Watchdog& watchdog);

  /// Time that connect() waits for a node, and callbacks meanwhile.
  struct Wait {
    std::chrono::milliseconds patience;
    bool respawn;                ///< whether roslaunch starts a dead node again, so that waiting for it makes sense
    std::function<bool()> stop;  ///< whether to give up
    /// Called with the namespace of the node's services when the wait has taken a second, with "" when it is there.
    std::function<void(const std::string&)> tell = [](const std::string&) {};
  };

  /// Waits until the peer describes itself. From then on, that instance must answer. Logs a wait of more than a second.
  /// Throws NodeMissing if no node answers within the patience or before `stop` holds, or if the node that the master
  /// knows is dead and `respawn` is false; InvalidInput if that node lives, but its service is of another type;
  /// BadDependency if that node answers with errors, or describes more than a thousand parameters; the peer's own error
  /// if the peer failed at its start.
  void connect(const Wait& wait);

  /// Throws PeerFault if the master names another node, or none, as the owner of the services.
  void requireSameOwner() const;

  const pusht_msgs::DescribeResponse& description() const { return description_; }
  const std::string& services() const { return services_; }

 private:
  template <class Service>
  friend class ServiceCaller;

  void requireInstance(const std::string& instance_id) const;
  void requireService(const std::string& service) const;
  [[noreturn]] void lose(const std::string& how) const;
  [[noreturn]] void raise(int exit_code, const std::string& message) const;

  std::string services_;
  Watchdog& watchdog_;
  pusht_msgs::DescribeResponse description_;
  std::string owner_;          // address of the node that serves
  mutable bool lost_ = false;  // since it was connected to
};

/// One service of a peer, over a persistent connection.
template <class Service>
class ServiceCaller {
 public:
  /// `peer` must outlive the caller.
  ServiceCaller(const Peer& peer, const std::string& service) : peer_(peer), name_(peer.services() + "/" + service) {}

  /// Throws PeerFault if the peer gives no answer in time, or is another instance than the one that was connected to;
  /// InvalidInput if it lives and never had such a service; the error it answers with if it refuses.
  typename Service::Response call(const typename Service::Request& request) {
    Service service;
    service.request = request;
    // A connection may break while the peer lives on. The peer recognizes a request that it has seen.
    if (!attempt(service) && !attempt(service)) {
      peer_.requireSameOwner();
      if (!served_) {  // else it has withdrawn it: it is about to end
        peer_.requireService(name_);
      }
      peer_.lose(name_ + ": the node has died or is out of reach");
    }
    served_ = true;
    peer_.requireInstance(service.response.instance_id);
    if (service.response.success == 0) {
      peer_.raise(service.response.exit_code, service.response.message);
    }
    return service.response;
  }

  /// Asks once and ignores the outcome; does nothing if the peer was lost.
  void tell(const typename Service::Request& request) noexcept {
    try {
      Service service;
      service.request = request;
      if (!peer_.lost_ && ros::ok()) {
        attempt(service);
      }
    } catch (const std::exception&) {
      // The peer is lost now.
    }
  }

 private:
  bool attempt(Service& service) {
    if (!client_.isValid()) {
      client_ = ros::NodeHandle().serviceClient<Service>(name_, true);
    }
    bool answered = false;
    bool interrupted = false;
    peer_.watchdog_.run([&] { answered = client_.call(service); },
                        [&] {
                          interrupted = true;
                          client_.shutdown();
                        });
    if (!answered && interrupted) {
      peer_.lose(name_ + ": no answer within " + std::to_string(peer_.watchdog_.deadline().count()) + " ms");
    }
    return answered;
  }

  const Peer& peer_;
  std::string name_;
  ros::ServiceClient client_;
  bool served_ = false;  // once
};

}  // namespace pusht
