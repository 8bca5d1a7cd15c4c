// SPDX-License-Identifier: BSD-3-Clause
/// Subjects of the suites of simulators: a kind, with parameters.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <iosfwd>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pusht_task/simulator_kind.hpp"
#include "pusht_task/task.hpp"
#include "pusht_testing/physics_of_kind.hpp"

namespace pusht::testing {

/// A kind of simulator with values for some of its parameters, by name, and the physics that it then claims to have.
struct Subject {
  SimulatorKind kind;
  std::map<std::string, std::string> settings{};
  PhysicsOfKind physics{};
  std::reference_wrapper<const Task> task = kind.ownTask();

  SimulatorModel load() const;
};

/// Idioms of an engine, whose physics the task's formulas do not describe: all of the kind's switches off, and each.
std::vector<Subject> idiomsOf(const SimulatorKind& kind);

/// Name of the subject in gtest's output.
void PrintTo(const Subject& subject, std::ostream* out);  // NOLINT(readability-identifier-naming)

/// Base of the suites: a kind of simulator with values of its parameters.
class SubjectSuite : public ::testing::TestWithParam<Subject> {
 protected:
  const SimulatorModel& model() const { return model_; }
  static const Task& task() { return GetParam().task; }
  std::unique_ptr<Simulator> makeWorld() const { return model_.make_world(); }
  std::unique_ptr<BatchSimulator> makeLanes(int lanes) const { return model_.make_lanes(lanes); }

  /// [m, rad, m/s, rad/s] What the kind says.
  static double startTolerance() { return GetParam().kind.start_tolerance; }

 private:
  SimulatorModel model_ = GetParam().load();
};

}  // namespace pusht::testing
