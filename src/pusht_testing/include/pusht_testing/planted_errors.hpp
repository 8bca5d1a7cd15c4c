// SPDX-License-Identifier: BSD-3-Clause
/// Errors that are easily made in an engine, planted in its scene (pusht_task/scene_world.hpp): the physics suite finds
/// each. In one source of a test, with laws of the package's own:
///
///     using Planted = PlantedIn<MineScene>;
///     std::vector<PlantedError> errors() {
///       return Planted::errors(minePhysics(), {Planted::law<OtherFriction>("other friction", minePhysics())});
///     }
///     INSTANTIATE_TEST_SUITE_P(Mine, PlantedErrorSuite, ::testing::ValuesIn(errors()));
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <functional>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "pusht_task/scene_world.hpp"
#include "pusht_testing/physics_of_kind.hpp"

namespace pusht::testing {

/// World with an error, and what its kind claims.
struct PlantedError {
  std::string name;
  std::function<std::unique_ptr<Simulator>()> make_world;
  PhysicsOfKind claims;
  std::string found_by{};  ///< a check that must find it; empty: any
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

/// Scene without the wall at -x.
template <class SceneOfKind>
struct ThreeWalls : SceneOfKind {
  using SceneOfKind::SceneOfKind;
  void addWalls() override {
    const auto walls = wallBoxes(this->physics());
    for (std::size_t wall = 0; wall < 3; ++wall) {
      this->addWall(walls[wall]);
    }
  }
};

/// Friction of the table at the tee's center of mass.
template <class SceneOfKind>
struct FrictionAtTheCenterOfMass : SceneOfKind {
  using SceneOfKind::SceneOfKind;
  void addTableFriction() override { this->addFrictionPerAxis({0.0, -this->physics().centerOfMass()}); }
};

/// Damping as a force on the body, as engines have it, at its center.
template <class SceneOfKind>
struct DampingAtTheCenterOfMass : SceneOfKind {
  using SceneOfKind::SceneOfKind;
  void applyDrag() override { this->applyDragAt({0.0, -this->physics().centerOfMass()}); }
};

/// Planted errors of a kind's scene.
template <class SceneOfKind>
struct PlantedIn {
  using Parameters = typename SceneOfKind::Parameters;

  /// Every one of wrongNumbers(), wrong laws that every scene can have, and then `more`.
  static std::vector<PlantedError> errors(const PhysicsOfKind& claims, const std::vector<PlantedError>& more) {
    std::vector<PlantedError> all;
    for (const WrongNumbers& wrong : wrongNumbers()) {
      all.push_back(planted<SceneOfKind>(wrong.name, claims, {}, wrong.physics));
    }
    all.push_back(law<ThreeWalls<SceneOfKind>>("three walls", claims));
    all.push_back(law<FrictionAtTheCenterOfMass<SceneOfKind>>("friction at the center of mass", claims));
    all.push_back(law<DampingAtTheCenterOfMass<SceneOfKind>>("damping at the center of mass", claims));
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  template <class SceneWithAnError>
  static PlantedError law(const std::string& name, const PhysicsOfKind& claims) {
    return planted<SceneWithAnError>(name, claims, {}, {});
  }

  /// The idiom in place of a choice of the mapping.
  static PlantedError idiom(bool Parameters::*choice, const PhysicsOfKind& claims, const std::string& found_by) {
    Parameters parameters;
    parameters.*choice = false;
    PlantedError error = planted<SceneOfKind>("idiom that is found by " + found_by, claims, parameters, {});
    error.found_by = found_by;
    return error;
  }

 private:
  template <class S>
  static PlantedError planted(const std::string& name, const PhysicsOfKind& claims, const Parameters& parameters,
                              const Physics& physics) {
    PlantedError error = {name, {}, claims};
    error.make_world = [parameters, physics] { return worldOf<S>(parameters, physics); };
    return error;
  }
};

/// Suite in which the physics checks must find each planted error.
class PlantedErrorSuite : public ::testing::TestWithParam<PlantedError> {
 public:
  static void SetUpTestSuite();  ///< does nothing; links the suite's tests into a program that instantiates it
};

}  // namespace pusht::testing
