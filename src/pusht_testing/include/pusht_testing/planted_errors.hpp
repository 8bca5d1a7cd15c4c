// SPDX-License-Identifier: BSD-3-Clause
/// Errors that are easily made in an engine, planted in its scene: the physics suite finds each. A package whose world
/// builds a scene from numbers of the task (Physics) instantiates the suite over them, and over scenes with laws of
/// their own, in one source of a test:
///
///     using Planted = PlantedIn<MineWorld, mine::Scene, MineParameters>;
///     std::vector<PlantedError> errors() {
///       return Planted::withNumbers(minePhysics(), {Planted::withLaw<ThreeWalls>("three walls", minePhysics())});
///     }
///     INSTANTIATE_TEST_SUITE_P(Mine, PlantedErrorSuite, ::testing::ValuesIn(errors()));
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <iosfwd>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pusht_task/physics.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_testing/physics_of_kind.hpp"

namespace pusht::testing {

/// World with an error, and what its kind claims.
struct PlantedError {
  std::string name;
  std::function<std::unique_ptr<Simulator>()> make_world;
  PhysicsOfKind claims;
};

/// Name of the error in gtest's output.
void PrintTo(const PlantedError& error, std::ostream* out);  // NOLINT(readability-identifier-naming)

/// Wrong numbers of the task.
struct WrongNumbers {
  const char* name;
  Physics physics;
};

/// Each number of the task that a motion depends on, too small or too large, and some that are easily confused.
std::vector<WrongNumbers> wrongNumbers();

/// Planted errors of worlds that build a scene from parameters and numbers of the task.
template <class World, class Scene, class Parameters>
struct PlantedIn {
  /// World without an error.
  static std::unique_ptr<Simulator> sound() { return worlds<Scene>({})(); }

  /// Every one of wrongNumbers(), and then `laws`.
  static std::vector<PlantedError> withNumbers(const PhysicsOfKind& claims, const std::vector<PlantedError>& laws) {
    std::vector<PlantedError> errors;
    for (const WrongNumbers& wrong : wrongNumbers()) {
      errors.push_back({wrong.name, worlds<Scene>(wrong.physics), claims});
    }
    errors.insert(errors.end(), laws.begin(), laws.end());
    return errors;
  }

  template <class SceneWithAnError>
  static PlantedError withLaw(std::string name, const PhysicsOfKind& claims) {
    PlantedError error{std::move(name), {}, claims};
    error.make_world = worlds<SceneWithAnError>({});
    return error;
  }

 private:
  template <class S>
  static std::function<std::unique_ptr<Simulator>()> worlds(const Physics& physics) {
    return
        [physics] { return std::make_unique<World>([physics] { return std::make_unique<S>(Parameters(), physics); }); };
  }
};

/// Suite in which the physics checks must find each planted error.
class PlantedErrorSuite : public ::testing::TestWithParam<PlantedError> {
 public:
  static void SetUpTestSuite();  ///< defined beside the test, so that a program which instantiates the suite has it
};

}  // namespace pusht::testing
