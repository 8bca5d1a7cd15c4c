// SPDX-License-Identifier: BSD-3-Clause
/// Interface of many worlds that step together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

/// Worlds of one kind, each in a lane. A lane has the bits of a Simulator of that kind, independent of the other lanes.
/// Not thread-safe.
class BatchSimulator {
 public:
  /// Action of the next control step, by lane. A lane without an action stays as it is.
  using Actions = Span<const std::optional<Action>>;

  BatchSimulator() = default;
  BatchSimulator(const BatchSimulator&) = delete;
  BatchSimulator& operator=(const BatchSimulator&) = delete;
  virtual ~BatchSimulator() = default;

  /// Number of lanes.
  virtual int lanes() const = 0;

  /// Resets a lane, as Simulator::reset(). If the world is not at `state` afterwards, the lane keeps that error.
  virtual void reset(int lane, const WorldState& state) = 0;

  /// Resets a lane to what its task draws for `seed`, as Simulator::spawn(). An error stays as reset() says.
  virtual void spawn(int lane, std::uint64_t seed) = 0;

  /// Steps every lane that has an action, as Simulator::step(). A lane's error does not stop the other lanes: the
  /// lane's state() throws it, and the lane stays as it is until it is reset.
  virtual void step(Actions actions) = 0;

  /// State of a lane, as Simulator::state(). Throws the error of the lane's last step, InvalidInput before its first
  /// reset.
  virtual WorldState state(int lane) const = 0;

  /// State of a lane, as Simulator::stateInPixels(). It has no meaning where state() throws.
  virtual const gym_pusht::State* stateInPixels(int /*lane*/) const { return nullptr; }
};

/// Faults of lanes, for implementations of BatchSimulator. Before its first reset a lane has the fault that it was not
/// reset.
class LaneFaults {
 public:
  explicit LaneFaults(std::size_t lanes);

  bool has(std::size_t lane) const { return faults_[lane] != nullptr; }
  /// Throws the fault of `lane`, if it has one; std::out_of_range if there is no such lane.
  void raise(std::size_t lane) const;

  /// Runs `call`, which resets `lane`, and rethrows its error. InvalidInput, a refusal, leaves the lane's fault as it
  /// was; any other error becomes the lane's fault; success clears it.
  template <class Call>
  void reset(std::size_t lane, const Call& call) {
    try {
      call();
      faults_.at(lane) = nullptr;
    } catch (const InvalidInput&) {
      throw;
    } catch (...) {
      faults_.at(lane) = std::current_exception();
      throw;
    }
  }

  /// Runs `call`, part of a step of `lane`. Its error becomes the lane's fault.
  template <class Call>
  void step(std::size_t lane, const Call& call) {
    try {
      call();
    } catch (...) {
      faults_[lane] = std::current_exception();
    }
  }

 private:
  std::vector<std::exception_ptr> faults_;  // by lane
};

/// Batch of any simulators, one for each lane, stepped one after the other.
class SimulatorLanes : public BatchSimulator {
 public:
  explicit SimulatorLanes(std::vector<std::unique_ptr<Simulator>> worlds);

  /// Batch of one lane.
  explicit SimulatorLanes(std::unique_ptr<Simulator> world);

  int lanes() const override { return static_cast<int>(worlds_.size()); }
  void reset(int lane, const WorldState& state) override;
  void spawn(int lane, std::uint64_t seed) override;
  void step(Actions actions) override;
  WorldState state(int lane) const override;
  const gym_pusht::State* stateInPixels(int lane) const override { return worlds_.at(lane)->stateInPixels(); }

 private:
  std::vector<std::unique_ptr<Simulator>> worlds_;
  LaneFaults faults_;
};

}  // namespace pusht
