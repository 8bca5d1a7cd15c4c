// SPDX-License-Identifier: BSD-3-Clause
#include "gym_pusht_kind.hpp"

#include <memory>
#include <optional>
#include <utility>

#include "chipmunk_types.hpp"
#include "gym_pusht_world.hpp"
#include "pusht_task/gym_pusht.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/simulator_plugin.hpp"
#include "pusht_task/switches.hpp"
#include "pusht_task/task.hpp"

namespace pusht {
namespace {

constexpr double kGymStartTolerance = 1e-12;  // [m, rad, m/s, rad/s]

/// World of gym-pusht in the table's frame. A start is put where it was asked to be: how gym-pusht's own resets move it
/// is part of the task's spawn.
class GymPushtSimulator : public Simulator {
 public:
  explicit GymPushtSimulator(const GymPushtQuirks& quirks)
      : Simulator("gym-pusht", kGymStartTolerance, gymPusht()), world_(quirks) {}

 private:
  void doReset(const WorldState& state) override {
    world_.restore(gym_pusht::fromTable(state, world_.centerOfGravity()));
    start_ = state;
  }

  void doStep(const Action& action) override {
    start_.reset();
    world_.step({action[0], action[1]});
  }

  /// Until the first step it is the start's, so that a reset to it changes no bit.
  WorldState doState() const override {
    return start_ ? *start_ : gym_pusht::toTable(world_.state(), world_.centerOfGravity());
  }

  GymPushtWorld world_;
  std::optional<WorldState> start_;
};

SimulatorModel loadGymPusht(const ParameterSet& set) {
  prepareChipmunk();
  GymPushtQuirks quirks;
  readSwitches(set, GymPushtWorld::kQuirks, quirks);
  SimulatorModel model = modelOfWorlds(set, [quirks] { return std::make_unique<GymPushtSimulator>(quirks); });
  model.make_in_pixels = [quirks](const gym_pusht::Variant& variant) {
    return std::make_unique<GymPushtWorld>(quirks, GymPushtResets(), variant);
  };
  return model;
}

}  // namespace

const SimulatorKind& gymPushtKind() {
  static const SimulatorKind kind = [] {
    const auto& quirks = GymPushtWorld::kQuirks;
    SimulatorKind made;
    made.name = "gym_pusht";
    made.title = "gym-pusht";
    made.version = cpVersionString;
    made.parameters = switchDescriptors(quirks, {presetOf("gym", quirks, true), presetOf("sound", quirks, false)});
    made.libraries = {"libchipmunk.so"};
    made.start_tolerance = kGymStartTolerance;
    made.loader = loadGymPusht;
    made.tasks = {gymPusht().name};
    made.departures = {"center_of_mass",   "tee_moment",  "tee_damping",   "tee_yaw_damping", "tee_yaw_friction",
                       "contact_friction", "pusher_mass", "wall_up",       "wall_down",       "wall_right",
                       "wall_left",        "tee_wall_up", "tee_wall_down", "tee_wall_right",  "tee_wall_left"};
    return made;
  }();
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(gym_pusht, pusht::gymPushtKind);
