// SPDX-License-Identifier: BSD-3-Clause
/// Interface of many worlds that step together.
#pragma once

#include <cstddef>
#include <exception>
#include <memory>
#include <optional>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

/// Worlds of one kind, each in a lane. What a lane does is what a Simulator of that kind does, bit for bit, and
/// never depends on the other lanes.
class BatchSimulator {
 public:
  /// For each lane the action of its next control step. A lane without one stays as it is.
  using Actions = Span<const std::optional<Action>>;

  BatchSimulator() = default;
  BatchSimulator(const BatchSimulator&) = delete;
  BatchSimulator& operator=(const BatchSimulator&) = delete;
  virtual ~BatchSimulator() = default;

  virtual int lanes() const = 0;

  /// As Simulator::reset. A world that starts elsewhere leaves its lane with that error.
  virtual void reset(int lane, const WorldState& state) = 0;

  /// As Simulator::step in every lane that has an action. The error of a lane does not keep the others from stepping:
  /// its state() throws it, and it stays as it is until it is reset.
  virtual void step(Actions actions) = 0;

  /// As Simulator::state. Throws what kept the lane from a step since its reset, InvalidInput before the first one.
  virtual WorldState state(int lane) const = 0;
};

/// What keeps each lane from going on, for whoever implements a BatchSimulator: at first, that nobody has reset it.
class LaneFaults {
 public:
  explicit LaneFaults(std::size_t lanes);

  bool has(std::size_t lane) const { return faults_[lane] != nullptr; }
  /// Throws the fault of `lane`, if it has one; std::out_of_range if there is no such lane.
  void raise(std::size_t lane) const;

  /// Runs `call`, which resets `lane`, and throws its error. After a refusal (InvalidInput) the lane is as it was, any
  /// other error is its fault, and without one it has none.
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

  /// Runs `call`, a part of a step of `lane`, whose error is the lane's fault.
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

/// Any simulators, one a lane, stepped one after the other.
class SimulatorLanes : public BatchSimulator {
 public:
  explicit SimulatorLanes(std::vector<std::unique_ptr<Simulator>> worlds);

  /// A single lane.
  explicit SimulatorLanes(std::unique_ptr<Simulator> world);

  int lanes() const override { return static_cast<int>(worlds_.size()); }
  void reset(int lane, const WorldState& state) override;
  void step(Actions actions) override;
  WorldState state(int lane) const override;

 private:
  std::vector<std::unique_ptr<Simulator>> worlds_;
  LaneFaults faults_;
};

}  // namespace pusht
