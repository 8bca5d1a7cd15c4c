// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/simulator_session.hpp"

#include <cmath>
#include <utility>

#include "pusht_task/clipped.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/reason.hpp"
#include "pusht_task/task.hpp"
#include "sim2sim_serving/conversions.hpp"
#include "sim2sim_serving/node.hpp"

namespace pusht {
namespace {

const ros::Duration kStampStep(kControlStep);

/// [s] What a caller may ask for. By hand no more than half of what a stamp can be: the runs that follow name stamps
/// too, and a slip must not spoil the world for them. After theirs, 11 days are left to count on from there.
constexpr std::uint32_t kStampLimitByHand = 1U << 31U;
constexpr std::uint32_t kStampLimit = 0U - 1'000'000U;

/// Hash of the parameters without the kind's name, because runs have recorded such hashes: two kinds may share one, and
/// callers look at `name`.
std::string hashOf(const Parameters& parameters) {
  if (parameters.empty()) {
    return "";
  }
  constexpr std::size_t kDigits = 12;
  std::string key;
  for (const pusht_msgs::Parameter& parameter : parameters) {
    key += parameter.name + "=" + parameter.value + "|";
  }
  return sha256(key).substr(0, kDigits);
}

std::vector<pusht_msgs::ParameterDescriptor> describeParameters(const ParameterSet& parameters) {
  std::vector<pusht_msgs::ParameterDescriptor> descriptors;
  for (const Parameter& parameter : parameters) {
    if (parameter.isRecorded()) {
      descriptors.push_back(toMessage(parameter.descriptor));
    }
  }
  return descriptors;
}

/// The reply to a request that `serve` fills, or that it refuses by an Error.
template <class Response, class Serve>
Response answer(const std::string& instance_id, const Serve& serve) {
  Response response;
  try {
    serve(response);
    response.success = 1;
  } catch (const std::exception& refusal) {
    response = Response();
    response.success = 0;
    response.message = clipped(refusal.what());
    response.exit_code = static_cast<int>(exitCodeOf(refusal));
  }
  response.instance_id = instance_id;
  return response;
}

/// Model of a kind. Its parameters have the task, as a run carries it.
SimulatorModel loadedInTask(const SimulatorKind& kind, ParameterSet parameters) {
  if (!parameters.has(kTaskParameter)) {
    parameters.add(withTask(kind).at(kTaskParameter));
  }
  parameters.set(kTaskParameter, textOf(taskNamed(parameters.get<std::string>(kTaskParameter))));
  SimulatorModel model = kind.load(parameters, taskNamed(parameters.get<std::string>(kTaskParameter)));
  if (!model.parameters.has(kTaskParameter)) {  // the kind names its own parameters alone
    model.parameters.add(parameters.at(kTaskParameter));
  }
  return model;
}

/// Resets `world` to the start of a request.
void reset(Simulator& world, const pusht_msgs::ResetRequest& request) {
  if (request.start.size() > 1) {
    throw InvalidInput("start: " + std::to_string(request.start.size()) + " states; must be one, or none for the seed");
  }
  if (request.start.empty()) {
    world.spawn(request.seed);
  } else if (request.drawn != 0) {
    world.spawn(request.seed, fromMessage(request.start.front()));
  } else {
    world.reset(fromMessage(request.start.front()));
  }
}

/// State of a world that is computed in pixels; none of any other.
std::vector<pusht_msgs::PixelState> reportedInPixels(const Simulator& world) {
  const gym_pusht::State* state = world.stateInPixels();
  return state == nullptr ? std::vector<pusht_msgs::PixelState>() : std::vector{toMessage(*state)};
}

}  // namespace

SimulatorSession::SimulatorSession(SimulatorKind kind, const ParameterSet& parameters, std::string frame_prefix,
                                   Observer observer, const SimulatorKinds* kinds)
    : kinds_(kinds),
      kind_(std::move(kind)),
      model_(loadedInTask(kind_, parameters)),
      world_(model_.make_world()),
      frame_prefix_(std::move(frame_prefix)),
      instance_id_(newInstanceId()),
      observer_(std::move(observer)) {}

pusht_msgs::ResetResponse SimulatorSession::reset(const pusht_msgs::ResetRequest& request) {
  if (isRepeated(request)) {
    return episode_->begun;
  }
  return answer<pusht_msgs::ResetResponse>(instance_id_, [&](pusht_msgs::ResetResponse& response) {
    const ros::Time stamp = request.silent != 0 ? stamp_ : nextStamp(request.stamp, request.token);
    try {
      pusht::reset(*world_, request);
    } catch (const InvalidInput&) {
      throw;  // refused; the world is as it was
    } catch (const std::exception&) {
      configuration_.reset();
      episode_.reset();
      throw;
    }
    configuration_.reset();
    stamp_ = stamp;
    response.success = 1;
    response.instance_id = instance_id_;
    response.stamp = stamp;
    response.state = toMessage(world_->state());
    response.state_in_pixels = reportedInPixels(*world_);
    response.parameters_hash = hashOf(toMessages(model_.parameters));
    const std::uint32_t horizon = request.horizon == 0 ? kHorizon : request.horizon;
    episode_ = Episode{request.episode, horizon, 0, false, request, response, {}, {}};
    observe({});
  });
}

pusht_msgs::StepResponse SimulatorSession::step(const pusht_msgs::StepRequest& request) {
  if (isRepeated(request)) {
    return episode_->taken;
  }
  return answer<pusht_msgs::StepResponse>(instance_id_, [&](pusht_msgs::StepResponse& response) {
    requireHold(request.token);
    requireStep(request);
    const Action action = {request.action[0], request.action[1]};
    const ros::Time stamp = episode_->begin.silent != 0 ? stamp_ : nextStamp(request.stamp, request.token);
    try {
      world_->step(action);
    } catch (const InvalidInput&) {
      throw;  // refused; the world is as it was
    } catch (const std::exception&) {
      episode_->failed = true;
      throw;
    }
    stamp_ = stamp;
    response.success = 1;
    response.instance_id = instance_id_;
    response.stamp = stamp;
    response.step = episode_->steps++;
    response.state = toMessage(world_->state());
    response.state_in_pixels = reportedInPixels(*world_);
    episode_->last = request;
    episode_->taken = response;
    observe(clip(action, world_->task()));
  });
}

pusht_msgs::ConfigureResponse SimulatorSession::configure(const pusht_msgs::ConfigureRequest& request) {
  if (isRepeated(request)) {
    return configuration_->answer;
  }
  return answer<pusht_msgs::ConfigureResponse>(instance_id_, [&](pusht_msgs::ConfigureResponse& response) {
    requireHold(request.token);
    if (inEpisode() && request.end_episode == 0) {
      throw InvalidInput("configure in mid-episode, after " + std::to_string(episode_->steps) + " of " +
                         std::to_string(episode_->horizon) + " control steps: set end_episode to end it");
    }
    SimulatorKind kind = request.kind.empty() ? kind_ : kindFor(request.kind);
    const ParameterSet parameters = request.kind.empty() ? model_.parameters : withTask(kind);
    SimulatorModel model = loadedInTask(kind, merged(parameters, request.parameters));
    world_ = model.make_world();
    model_ = std::move(model);
    kind_ = std::move(kind);
    episode_.reset();
    response.success = 1;
    response.instance_id = instance_id_;
    response.parameters = toMessages(model_.parameters);
    response.parameters_hash = hashOf(toMessages(model_.parameters));
    configuration_ = Configuration{request, response};
  });
}

pusht_msgs::DescribeResponse SimulatorSession::describe(const pusht_msgs::DescribeRequest& request) const {
  return answer<pusht_msgs::DescribeResponse>(instance_id_, [&](pusht_msgs::DescribeResponse& response) {
    const bool as_it_is = request.kind.empty();
    const SimulatorKind& kind = as_it_is ? kind_ : kindFor(request.kind);
    const ParameterSet parameters = as_it_is ? model_.parameters : withTask(kind);
    response.name = kind.name;
    response.kinds = kinds_ == nullptr ? std::vector<std::string>() : kinds_->names();
    response.title = kind.title;
    response.version = kind.version;
    response.parameters = toMessages(parameters);
    response.parameter_descriptors = describeParameters(parameters);
    response.start_tolerance = kind.start_tolerance;
    if (as_it_is) {  // else what the kind would make of its parameters is known once it is loaded
      response.parameters_hash = hashOf(response.parameters);
      response.provenance = model_.provenance.dump();
    }
    response.frame_prefix = frame_prefix_;
    response.stamp = stamp_;
  });
}

bool SimulatorSession::isRepeated(const pusht_msgs::ResetRequest& request) const {
  return episode_ && !episode_->failed && episode_->steps == 0 && !request.stamp.isZero() && request == episode_->begin;
}

bool SimulatorSession::isRepeated(const pusht_msgs::StepRequest& request) const {
  return episode_ && !episode_->failed && episode_->steps > 0 &&
         request.step == static_cast<std::int64_t>(episode_->steps) - 1 && request.episode == episode_->index &&
         request.token == episode_->last.token && request.action == episode_->last.action &&
         request.stamp == episode_->last.stamp;
}

bool SimulatorSession::isRepeated(const pusht_msgs::ConfigureRequest& request) const {
  return configuration_ && request == configuration_->request;
}

void SimulatorSession::requireHold(const std::string& token) const {
  const std::string holder = episode_ ? episode_->begin.token : "";
  if (token == holder) {
    return;
  }
  throw RuntimeFault(token.empty()
                         ? "the world is held by another caller: wait for its end, or take the world over by a reset"
                         : "the world was reset by another caller, or its episode has ended: reset it to go on");
}

void SimulatorSession::requireStep(const pusht_msgs::StepRequest& request) const {
  if (!episode_) {
    throw InvalidInput("step before reset: call reset first");
  }
  if (episode_->failed) {
    throw InvalidInput("step after a failed one: the world needs a reset");
  }
  if (request.episode != episode_->index) {
    throw InvalidInput("episode " + std::to_string(request.episode) + ": must be " + std::to_string(episode_->index) +
                       ", the one under way");
  }
  if (episode_->steps > 0 && request.step == static_cast<std::int64_t>(episode_->steps) - 1) {
    throw InvalidInput("step " + std::to_string(request.step) + ": was taken with another action or stamp");
  }
  if (request.step != -1 && request.step != static_cast<std::int64_t>(episode_->steps)) {
    throw InvalidInput("step " + std::to_string(request.step) + ": expected " + std::to_string(episode_->steps));
  }
  if (episode_->steps >= episode_->horizon) {
    throw InvalidInput("step " + std::to_string(episode_->steps) + ": the horizon of " +
                       std::to_string(episode_->horizon) + " control steps is reached");
  }
  if (!std::isfinite(request.action[0]) || !std::isfinite(request.action[1])) {
    throw InvalidInput("action (" + shortestText(request.action[0]) + ", " + shortestText(request.action[1]) +
                       "): must be finite");
  }
}

ros::Time SimulatorSession::nextStamp(const ros::Time& requested, const std::string& token) const {
  if (requested.isZero()) {
    return stamp_ + kStampStep;
  }
  if (requested <= stamp_) {
    throw InvalidInput("stamp " + std::to_string(requested.toSec()) + ": must be above " +
                       std::to_string(stamp_.toSec()) + ", the last one [s]");
  }
  if (requested.sec >= (token.empty() ? kStampLimitByHand : kStampLimit)) {
    throw InvalidInput("stamp " + std::to_string(requested.toSec()) + ": must be below " +
                       (token.empty() ? "2^31 [s] without a token" : "2^32 - 10^6 [s]"));
  }
  return requested;
}

void SimulatorSession::observe(const Action& action) const {
  if (episode_->begin.silent != 0) {
    return;
  }
  pusht_msgs::WorldStateStamped update;
  update.header.stamp = stamp_;
  update.header.frame_id = frame_prefix_ + "/table";
  update.episode = episode_->index;
  update.step = episode_->steps;
  update.action = {action[0], action[1]};
  update.state = toMessage(world_->state());
  observer_(update);
}

bool SimulatorSession::inEpisode() const {
  return episode_ && !episode_->failed && episode_->steps < episode_->horizon;
}

const SimulatorKind& SimulatorSession::kindFor(const std::string& name) const {
  if (name == kind_.name) {
    return kind_;
  }
  if (kinds_ == nullptr) {
    throw InvalidInput("simulator '" + name + "': must be " + kind_.name + ", the only kind that this node can be");
  }
  return kinds_->named(name);
}

pusht_msgs::DescribeResponse describeFailure(const std::exception& failure) {
  pusht_msgs::DescribeResponse response;
  response.success = 0;
  response.message = clipped(reasonOf(failure));
  response.exit_code = static_cast<int>(exitCodeOf(failure));
  response.instance_id = newInstanceId();
  return response;
}

}  // namespace pusht
