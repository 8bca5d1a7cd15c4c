// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/peer.hpp"

#include <ros/console.h>
#include <ros/master.h>
#include <ros/service.h>
#include <ros/service_manager.h>

#include <algorithm>
#include <gsl/util>
#include <utility>

#include "pusht_task/clipped.hpp"

namespace pusht {
namespace {

constexpr std::chrono::milliseconds kConnectPeriod{20};          // doubles with each refusal
constexpr std::chrono::milliseconds kLongestConnectPeriod{320};  // between refusals, each of which roscpp logs
constexpr std::chrono::seconds kSilence{1};                      // wait before it is logged
constexpr std::chrono::seconds kDeadOrNever{3};                  // a node accepts connections before it is registered
constexpr std::size_t kMostParameters = 1000;                    // each is shown, compared and kept

/// Host and port of the node that the master knows for `service`; empty if there is none.
std::string ownerOf(const std::string& service) {
  std::string host;
  std::uint32_t port = 0;
  return ros::ServiceManager::instance()->lookupService(service, host, port) ? host + ":" + std::to_string(port) : "";
}

}  // namespace

Watchdog::Watchdog(std::chrono::milliseconds deadline) : deadline_(deadline), thread_([this] { watch(); }) {}

Watchdog::~Watchdog() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  ending_changed_.notify_one();
  thread_.join();
}

void Watchdog::run(const std::function<void()>& call, const std::function<void()>& interrupt) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    interrupt_ = &interrupt;
    expiry_ = std::chrono::steady_clock::now() + deadline_;
  }
  const auto disarm = gsl::finally([this] {
    const std::lock_guard<std::mutex> lock(mutex_);
    interrupt_ = nullptr;
  });
  call();
}

void Watchdog::watch() {
  std::unique_lock<std::mutex> lock(mutex_);
  // Calls are short and many: none wakes this thread. A call that begins while it waits expires after it wakes.
  while (!ending_) {
    const auto now = std::chrono::steady_clock::now();
    if (interrupt_ != nullptr && now >= expiry_) {
      (*std::exchange(interrupt_, nullptr))();
    }
    ending_changed_.wait_until(lock, interrupt_ != nullptr ? expiry_ : now + deadline_);
  }
}

Peer::Peer(std::string services, Watchdog& watchdog) : services_(std::move(services)), watchdog_(watchdog) {}

void Peer::connect(const Wait& wait) {
  const auto begin = std::chrono::steady_clock::now();
  const auto expiry = begin + wait.patience;
  const std::string service = services_ + "/describe";
  pusht_msgs::Describe describe;
  bool answered = false;
  bool said = false;
  auto last_sign = begin;  // of life
  auto period = kConnectPeriod;
  while (!answered) {
    if (!said && std::chrono::steady_clock::now() - begin > kSilence) {
      ROS_WARN_STREAM("waiting for the node of "
                      << service << ", for " << std::chrono::duration<double>(wait.patience).count() << " s at most");
      said = true;
      wait.tell(services_);
    }
    if (wait.stop()) {
      throw NodeMissing(service + ": no node answers");
    }
    if (std::chrono::steady_clock::now() >= expiry) {
      throw NodeMissing(service + ": no node answers within " + std::to_string(wait.patience.count()) + " ms",
                        services_);
    }
    const std::string owner = std::exchange(owner_, ownerOf(service));
    bool late = false;
    bool errs = false;
    if (!owner_.empty()) {
      ros::ServiceClient client = ros::NodeHandle().serviceClient<pusht_msgs::Describe>(service, true);
      watchdog_.run([&] { answered = client.isValid() && client.call(describe); },
                    [&] {
                      late = true;
                      client.shutdown();
                    });
      errs = !answered && !late && client.isValid();  // a service of another type, and a dead node, do not connect
    }
    const bool may_live = owner_.empty() || owner_ != owner || late || answered;
    answered = answered && ownerOf(service) == owner_;  // not one that has come in its place meanwhile
    if (may_live) {
      last_sign = std::chrono::steady_clock::now();
    } else if (!wait.respawn && std::chrono::steady_clock::now() - last_sign > kDeadOrNever) {
      // A node that begins, or ends, may err for a moment; and roscpp holds a connection to one that has died for valid
      // until its poll thread has seen the end.
      const bool listens = ros::service::exists(service, false);
      if (listens && errs) {
        throw BadDependency(service + ": the node at " + owner_ + " answers with an error; its log says why");
      }
      if (listens) {  // takes connections, and refuses each call
        throw InvalidInput(service + ": the service of the node at " + owner_ +
                           " is of another type than pusht_msgs/Describe: is it a node of another task?");
      }
      throw NodeMissing(service + ": the master knows a node at " + owner_ + ", but nothing answers there: it has died",
                        services_);
    }
    period = may_live ? kConnectPeriod : std::min(2 * period, kLongestConnectPeriod);
    if (!answered) {
      ros::WallDuration(std::chrono::duration<double>(period).count()).sleep();
    }
  }
  if (said) {
    wait.tell("");
  }
  lost_ = false;
  description_ = describe.response;
  if (description_.success == 0) {
    raise(description_.exit_code, description_.message);
  }
  if (description_.parameters.size() > kMostParameters) {
    throw BadDependency(services_ + ": describes " + std::to_string(description_.parameters.size()) +
                        " parameters: must be at most " + std::to_string(kMostParameters));
  }
}

void Peer::requireSameOwner() const {
  const std::string owner = ownerOf(services_ + "/describe");
  if (owner.empty()) {
    if (!ros::master::check()) {
      lost_ = true;
      throw PeerFault("the ROS master at " + ros::master::getURI() + " has died");
    }
    lose(services_ + ": the node has gone: it was shut down, or a second node of that name has replaced it");
  }
  if (owner != owner_) {
    lose(services_ + ": its services belong to another node (" + owner + ") than the one connected to (" + owner_ +
         "); is there a second node of that name?");
  }
}

void Peer::raise(int exit_code, const std::string& message) const {
  const auto code = static_cast<ExitCode>(exit_code);
  if (code == ExitCode::kInvalidInput) {
    throw InvalidInput(services_ + ": " + clipped(message));
  }
  for (const ExitCode known : {ExitCode::kRuntimeFault, ExitCode::kInternalError}) {
    if (code == known) {
      throw Error(code, services_ + ": " + clipped(message));
    }
  }
  throw BadDependency(services_ + ": " + clipped(message));  // of a node that knows no exit codes, too
}

void Peer::requireInstance(const std::string& instance_id) const {
  if (instance_id != description_.instance_id) {
    lose(services_ + ": another instance (" + instance_id + ") answers than the one connected to (" +
         description_.instance_id + "): it was restarted, or there are two");
  }
}

void Peer::requireService(const std::string& service) const {
  if (ownerOf(service).empty()) {
    throw InvalidInput(service + ": the node of " + services_ + " is '" + description_.name +
                       "', which has no such service: is it the right node?");
  }
}

void Peer::lose(const std::string& how) const {
  lost_ = true;
  throw PeerFault(how, services_);
}

}  // namespace pusht
