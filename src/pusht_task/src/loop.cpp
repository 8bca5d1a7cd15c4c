// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/loop.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string_view>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/gym_pusht.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"

namespace pusht {
namespace {

constexpr const char* kLoopPreset = "preset";

/// Values of the parameters, in the units of a task's observations and actions.
struct Loop {
  Loop(const ParameterSet& set, const Task& of_task)
      : task(of_task),
        observation_delay(static_cast<std::size_t>(set.get<std::int64_t>("observation_delay"))),
        action_delay(static_cast<std::size_t>(set.get<std::int64_t>("action_delay"))),
        hold(set.get<std::int64_t>("hold")),
        action_scale(set.get<double>("action_scale")),
        position_noise(set.get<double>("observation_noise_position") * task.frame.per_meter),
        yaw_noise(set.get<double>("observation_noise_yaw")),
        action_noise(set.get<double>("action_noise") * actionPerSpeed(task)) {}

  const Task& task;
  std::size_t observation_delay;
  std::size_t action_delay;
  std::int64_t hold;
  double action_scale;
  double position_noise;  // [unit of the task's frame]
  double yaw_noise;       // [rad]
  double action_noise;    // [unit of the task's actions]
};

/// Normal numbers of one stream of a rollout.
class Noise {
 public:
  Noise(std::uint64_t seed, const std::string& purpose, double deviation)
      : generator_(seed, purpose), deviation_(deviation) {}

  bool isOn() const { return deviation_ > 0.0; }
  double next() { return deviation_ * normal_(generator_.bits()); }

 private:
  NumpyGenerator generator_;
  boost::random::normal_distribution<double> normal_;
  double deviation_;
};

/// Clipped command; one that is not finite is nothing to clip.
Action clippedIfFinite(const Action& command, const Task& task) {
  return isFinite(command) ? clip(command, task) : command;
}

/// Observation of a world, and the state behind it.
struct Shown {
  Observation observation{};
  bool has_state = false;  ///< not if the observation came over a node
  WorldState state{};
  bool has_pixels = false;  ///< not unless world and sensors have the bits of `in_pixels`
  gym_pusht::State in_pixels{};
};

/// Errors of a sensor, in the units and the frame of a task's observations.
struct SensorError {
  std::array<double, 4> positions{};  ///< of pusher x, y, tee x, y
  double yaw = 0.0;                   ///< [rad]
};

/// Queue in which everything waits for `delay` steps.
template <class Value>
class Delay {
 public:
  explicit Delay(std::size_t delay) : delay_(delay) {}

  /// What is due now that `value` has come; in the first `delay` steps, `before`.
  Value pass(const Value& value, const Value& before) {
    if (waiting_.empty()) {
      waiting_.assign(delay_, before);
    }
    waiting_.push_back(value);
    Value due = waiting_.front();
    waiting_.pop_front();
    return due;
  }

 private:
  std::size_t delay_;
  std::deque<Value> waiting_;
};

/// Loop of one rollout, with the memory of its policy.
class LoopMemory : public Policy::Memory {
 public:
  LoopMemory(const Loop& loop, std::uint64_t seed, std::unique_ptr<Policy::Memory> memory)
      : loop_(loop),
        memory_(std::move(memory)),
        position_noise_(seed, "loop position noise", loop.position_noise),
        yaw_noise_(seed, "loop yaw noise", loop.yaw_noise),
        action_noise_(seed, "loop action noise", loop.action_noise),
        observations_(loop.observation_delay),
        commands_(loop.action_delay) {}

  /// What the policy is asked now that the world shows what `query` has.
  Policy::Query queryOf(const Policy::Query& query) {
    rest_ = restAt(query.observation);
    const Shown now = measured(query);
    seen_ = observations_.pass(now, now);
    return {seen_.observation, memory_.get(), seen_.has_state ? &seen_.state : nullptr,
            seen_.has_pixels ? &seen_.in_pixels : nullptr};
  }

  /// Whether the policy acts in this control step.
  bool acts() const { return step_ % loop_.hold == 0; }

  void take(const Action& answer) { held_ = answer; }

  /// Command that reaches the world in this control step, which ends.
  Action command() {
    ++step_;
    Action command = held_;
    if (loop_.action_scale != 1.0) {
      command = scaled(clippedIfFinite(command, loop_.task));
    }
    command = commands_.pass(command, rest_);
    if (action_noise_.isOn()) {
      command = clippedIfFinite(command, loop_.task);
      for (float& component : command) {
        component += static_cast<float>(action_noise_.next());
      }
    }
    return command;
  }

 private:
  bool commandsPositions() const { return loop_.task.physics.drive == Drive::kPosition; }

  /// Command that leaves the pusher where it is.
  Action restAt(const Observation& truth) const { return commandsPositions() ? Action{truth[0], truth[1]} : Action{}; }

  Action scaled(const Action& command) const {
    Action scaled{};
    for (std::size_t axis = 0; axis < command.size(); ++axis) {
      const double way = (command[axis] - rest_[axis]) * loop_.action_scale;
      scaled[axis] = static_cast<float>(commandsPositions() ? rest_[axis] + way : way);  // 0 + -0 would lose a sign
    }
    return scaled;
  }

  bool errs() const { return position_noise_.isOn() || yaw_noise_.isOn(); }

  Shown measured(const Policy::Query& truth) {
    SensorError error;
    if (position_noise_.isOn()) {
      std::generate(error.positions.begin(), error.positions.end(), [&] { return position_noise_.next(); });
    }
    if (yaw_noise_.isOn()) {
      error.yaw = yaw_noise_.next();
    }
    Shown shown = {measured(truth.observation, error), truth.state != nullptr};
    if (shown.has_state) {
      shown.state = measured(*truth.state, error);
    }
    shown.has_pixels = truth.state_in_pixels != nullptr && !errs();
    if (shown.has_pixels) {
      shown.in_pixels = *truth.state_in_pixels;
    }
    return shown;
  }

  Observation measured(Observation observation, const SensorError& error) const {
    constexpr std::size_t kSin = 4;
    constexpr std::size_t kCos = 5;
    if (position_noise_.isOn()) {  // the target is known
      for (std::size_t i = 0; i < error.positions.size(); ++i) {
        observation[i] += static_cast<float>(error.positions[i]);
      }
    }
    if (yaw_noise_.isOn()) {
      const double yaw = std::atan2(observation[kSin], observation[kCos]) + error.yaw;
      observation[kSin] = static_cast<float>(std::sin(yaw));
      observation[kCos] = static_cast<float>(std::cos(yaw));
    }
    return observation;
  }

  WorldState measured(WorldState state, const SensorError& error) const {
    if (!errs()) {
      return state;
    }
    const TaskFrame& frame = loop_.task.frame;
    const auto [pusher_x, pusher_y, tee_x, tee_y] = error.positions;
    Pose tee = frame.poseFromTable({state.tee_position, state.tee_yaw});
    tee = frame.poseToTable({tee.position + Eigen::Vector2d(tee_x, tee_y), tee.yaw + error.yaw});
    state.pusher_position += frame.vectorToTable({pusher_x, pusher_y});
    state.tee_position = tee.position;
    state.tee_yaw = tee.yaw;
    return state;
  }

  const Loop& loop_;
  std::unique_ptr<Policy::Memory> memory_;
  Noise position_noise_;
  Noise yaw_noise_;
  Noise action_noise_;
  Delay<Shown> observations_;
  Delay<Action> commands_;
  std::int64_t step_ = 0;
  Shown seen_{};  ///< by the policy
  Action rest_{};
  Action held_{};
};

class LoopedPolicy : public Policy {
 public:
  LoopedPolicy(std::unique_ptr<Policy> policy, const ParameterSet& reference, const ParameterSet& engine,
               const Task& task)
      : policy_(std::move(policy)), reference_(reference, task), engine_(engine, task) {}

  std::unique_ptr<Memory> begin(const Beginning& beginning) const override {
    const Loop& loop = beginning.role == Role::kReference ? reference_ : engine_;
    return std::make_unique<LoopMemory>(loop, beginning.seed, policy_->begin(beginning));
  }

  void act(Span<const Query> queries, Span<Action> actions) override {
    asked_.clear();
    for (const Query& query : queries) {
      const Query inner = memoryOf(query).queryOf(query);
      if (memoryOf(query).acts()) {
        asked_.push_back(inner);
      }
    }
    answers_.resize(asked_.size());
    if (!asked_.empty()) {
      policy_->act(asked_, answers_);
    }
    std::size_t next = 0;
    for (std::size_t i = 0; i < queries.size(); ++i) {
      LoopMemory& memory = memoryOf(queries[i]);
      if (memory.acts()) {
        memory.take(answers_.at(next++));
      }
      actions[i] = memory.command();
    }
  }

 private:
  static LoopMemory& memoryOf(const Query& query) {
    auto* memory = dynamic_cast<LoopMemory*>(query.memory);
    if (memory == nullptr) {
      throw InternalError("policy in a loop: a query must carry a memory from begin()");
    }
    return *memory;
  }

  std::unique_ptr<Policy> policy_;
  Loop reference_;
  Loop engine_;
  std::vector<Query> asked_;
  std::vector<Action> answers_;
};

ParameterDescriptor steps(const char* name, const char* meaning, std::int64_t usual) {
  constexpr double kMostSteps = 100.0;
  return {name, "control steps", meaning, usual, static_cast<double>(usual), kMostSteps};
}

/// Loops with a name. `tracker`: a camera over the table follows tags on pusher and tee, which its sources
/// (docs/loop.md) put at 0.4 to 2 mm, and at 0.01 rad with tags of 5 cm; a frame of 33 ms, its transfer and the
/// detection take one control step, the nearest whole number.
ParameterDescriptor presets() {
  ParameterDescriptor words = {kLoopPreset, "", "loop with a name; sets the parameters that are not set by name",
                               "none"};
  words.words = {"none", "tracker"};
  words.presets = {
      {"none", {{"observation_delay", "0"}, {"observation_noise_position", "0"}, {"observation_noise_yaw", "0"}}},
      {"tracker",
       {{"observation_delay", "1"}, {"observation_noise_position", "0.002"}, {"observation_noise_yaw", "0.01"}}}};
  return words;
}

ParameterDescriptor deviation(const char* name, const char* unit, const char* meaning) {
  constexpr double kMost = 10.0;
  return {name, unit, meaning, 0.0, 0.0, kMost};
}

}  // namespace

const std::vector<ParameterDescriptor>& loopParameters() {
  constexpr double kMostScale = 10.0;
  static const std::vector<ParameterDescriptor> parameters = {
      presets(),
      steps("action_delay",
            "from a command to its beginning in the world; before the first, it is that of a pusher at rest", 0),
      steps("observation_delay", "age of the observation that the policy gets; the first one is repeated", 0),
      steps("hold", "the policy is asked every so many control steps; its command is held in between", 1),
      {"action_scale", "", "factor of the clipped command, or of the way to it if it is a position", 1.0, 0.0,
       kMostScale},
      deviation("action_noise", "m/s", "standard deviation of the noise on each component of the clipped command"),
      deviation("observation_noise_position", "m", "standard deviation of the noise on x and y of pusher and tee"),
      deviation("observation_noise_yaw", "rad", "standard deviation of the noise on the tee's yaw"),
  };
  return parameters;
}

ParameterSet plainLoop() { return ParameterSet(loopParameters()); }

bool isPlain(const ParameterSet& loop) {
  return std::all_of(loop.begin(), loop.end(), [](const Parameter& parameter) { return parameter.isDefault(); });
}

std::string loopParameterOf(const std::string& name) {
  const std::string_view prefix = kLoopPrefix;
  return name.compare(0, prefix.size(), prefix) == 0 ? name.substr(prefix.size()) : "";
}

std::pair<std::string, std::string> loopSettingFrom(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals != std::string::npos) {
    return {text.substr(0, equals), text.substr(equals + 1)};
  }
  const ParameterSet loop = plainLoop();
  const std::vector<std::string>& words = loop.at(kLoopPreset).descriptor.words;
  if (std::find(words.begin(), words.end(), text) == words.end()) {
    throw InvalidInput("loop '" + text + "': must be NAME=VALUE, or one of: " + joined(words));
  }
  return {kLoopPreset, text};
}

std::string textOf(const ParameterSet& loop) {
  std::string text;
  for (const auto& [name, value] : fewestSettings(loop, plainLoop())) {
    text += (text.empty() ? "" : ", ") + (name == kLoopPreset ? value : name + " " + value);
  }
  return text;
}

void setOfLoop(ParameterSet& loop, const std::string& name, const std::string& text) {
  try {
    loop.set(name, text);
  } catch (Error& error) {
    error.addContext("loop");
    throw;
  }
}

std::unique_ptr<Policy> looped(std::unique_ptr<Policy> policy, const ParameterSet& reference,
                               const ParameterSet& engine, const Task& task) {
  if (isPlain(reference) && isPlain(engine)) {
    return policy;
  }
  return std::make_unique<LoopedPolicy>(std::move(policy), reference, engine, task);
}

}  // namespace pusht
