// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/remote_simulator.hpp"

#include <algorithm>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"
#include "sim2sim_serving/conversions.hpp"
#include "sim2sim_serving/node.hpp"

namespace pusht {
namespace {

/// The answer of a world that is ours. What we ask is right: a world that does not take it is not as we left it.
template <class Service>
typename Service::Response answerOf(ServiceCaller<Service>& caller, const typename Service::Request& request) {
  try {
    return caller.call(request);
  } catch (const Error& refusal) {
    if (refusal.exitCode() != ExitCode::kInvalidInput) {
      throw;
    }
    throw RuntimeFault(std::string(refusal.what()) + "; is there another caller?");
  }
}

/// Sets the task among the `changes` of a node, unless that is full_circle and the node says of no other.
void setTask(const Task& task, bool says_task, Parameters& changes) {
  changes = withoutTask(std::move(changes));
  if (&task != &fullCircle() || says_task) {
    changes.push_back(parameter(kTaskParameter, textOf(task)));
  }
}

/// Description of the peer as it would be as one of `kind`, without a change of the peer.
pusht_msgs::DescribeResponse describedAs(const std::string& kind, const Peer& peer) {
  if (kind.empty()) {
    return peer.description();
  }
  pusht_msgs::DescribeRequest request;
  request.kind = kind;
  pusht_msgs::DescribeResponse description = ServiceCaller<pusht_msgs::Describe>(peer, "describe").call(request);
  if (description.name != kind) {
    throw BadDependency(peer.services() + ": describes '" + description.name + "': must be '" + kind +
                        "', which it was asked for");
  }
  return description;
}

}  // namespace

double startToleranceOf(const pusht_msgs::DescribeResponse& description) {
  if (description.start_tolerance == 0.0) {
    return kStartTolerance;
  }
  try {
    return checkedStartTolerance(description.start_tolerance);
  } catch (const InvalidInput& refusal) {
    throw BadDependency(description.name + ": " + refusal.what());
  }
}

void StampSource::advance() { now_ += ros::Duration(kControlStep); }

void StampSource::raiseTo(const ros::Time& stamp) { now_ = std::max(now_, stamp); }

RemoteSimulator::RemoteSimulator(const Peer& peer, const StampSource& stamps,
                                 const pusht_msgs::DescribeResponse& description, const Task& task)
    : Simulator(peer.services(), startToleranceOf(description), task),
      peer_(peer),
      stamps_(stamps),
      describe_(peer, "describe"),
      configure_(peer, "configure"),
      reset_(peer, "reset"),
      step_(peer, "step"),
      kind_(peer.description().name),
      version_(description.version),
      says_task_(taskIn(description.parameters).has_value()),
      parameters_hash_(peer.description().parameters_hash) {}

// Delegates, so that the destructor lets go of a world that refuses what follows.
RemoteSimulator::RemoteSimulator(const Peer& peer, StampSource& stamps, const std::string& kind, Parameters changes,
                                 const Task& task)
    : RemoteSimulator(peer, stamps, describedAs(kind, peer), task) {
  setTask(task, says_task_, changes);
  stamps.raiseTo(peer.description().stamp);
  stamps.advance();
  silent_ = true;                     // what is shown of the last run stays, should this one not begin
  pusht_msgs::ResetRequest anywhere;  // a start, as nodes need not have the seeds of other tasks than full_circle
  const std::string said = taskIn(peer.description().parameters).value_or(fullCircle().name);
  const Task& now = taskNamed(said);
  anywhere.start = {toMessage(pusht::spawn(now.first_spawn_seed, now))};
  requireParameters(take(anywhere).parameters_hash);
  silent_ = false;
  if (!kind.empty() || !changes.empty()) {
    configure(kind, changes);
  }
}

RemoteSimulator::~RemoteSimulator() {
  if (token_.empty()) {
    return;
  }
  pusht_msgs::ConfigureRequest request;
  request.end_episode = 1;
  request.token = token_;
  configure_.tell(request);
}

void RemoteSimulator::announce(std::uint64_t episode, int horizon) {
  episode_ = episode;
  horizon_ = horizon;
  silent_ = false;
}

void RemoteSimulator::configure(const std::string& kind, const Parameters& changes) {
  pusht_msgs::ConfigureRequest request;
  request.kind = kind;
  request.parameters = changes;
  request.end_episode = 1;
  request.token = token_;
  parameters_hash_ = configure_.call(request).parameters_hash;
  kind_ = kind.empty() ? kind_ : kind;
  token_.clear();
}

pusht_msgs::DescribeResponse RemoteSimulator::describe() {
  pusht_msgs::DescribeResponse description = describe_.call({});
  if (description.name != kind_) {
    throw RuntimeFault(peer_.services() + ": is '" + description.name + "': must be '" + kind_ +
                       "'; another caller has configured the world");
  }
  if (description.version != version_) {
    throw BadDependency(peer_.services() + ": is '" + kind_ + "' in version '" + description.version +
                        "': must be in '" + version_ + "', as it said before");
  }
  requireParameters(description.parameters_hash);
  return description;
}

void RemoteSimulator::doReset(const WorldState& state) { requestReset(state, {}); }

void RemoteSimulator::doSpawn(const WorldState& start, std::uint64_t seed) {
  pusht_msgs::ResetRequest request;
  request.seed = seed;
  request.drawn = 1;
  requestReset(start, request);
}

/// Sends `start` always, as not every node can draw the seeds of every task.
void RemoteSimulator::requestReset(const WorldState& start, pusht_msgs::ResetRequest request) {
  request.start = {toMessage(start)};
  request.episode = episode_;
  request.horizon = static_cast<std::uint32_t>(horizon_);
  const pusht_msgs::ResetResponse response = take(request);
  requireParameters(response.parameters_hash);
  keepState(response);
  next_step_ = 0;
}

void RemoteSimulator::doStep(const Action& action) {
  pusht_msgs::StepRequest request;
  request.episode = episode_;
  request.step = next_step_;
  request.action = {action[0], action[1]};
  request.stamp = silent_ ? ros::Time() : stamps_.now();
  request.token = token_;
  keepState(answerOf(step_, request));
  ++next_step_;
}

template <class Response>
void RemoteSimulator::keepState(const Response& response) {
  state_ = fromMessage(response.state);
  try {
    state_in_pixels_ = inPixels(response.state_in_pixels, state_);
  } catch (Error& fault) {
    fault.addContext(peer_.services());
    throw;
  }
}

pusht_msgs::ResetResponse RemoteSimulator::take(pusht_msgs::ResetRequest request) {
  token_ = newInstanceId();
  request.token = token_;
  request.silent = silent_ ? 1 : 0;
  request.stamp = silent_ ? ros::Time() : stamps_.now();
  return answerOf(reset_, request);
}

void RemoteSimulator::requireParameters(const std::string& hash) const {
  if (hash != parameters_hash_) {
    throw RuntimeFault(peer_.services() + ": parameters with the hash '" + hash + "': must be those with '" +
                       parameters_hash_ + "'; another caller has configured the world");
  }
}

}  // namespace pusht
