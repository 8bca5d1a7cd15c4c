// SPDX-License-Identifier: BSD-3-Clause
#include "gym_pusht_kind.hpp"

#include <cstdint>
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

/// World of gym-pusht in the table's frame. A start that is given is put where it was asked to be; one that is drawn is
/// reset as gym-pusht does it, which moves it to the task's spawn.
class GymPushtSimulator : public Simulator {
 public:
  explicit GymPushtSimulator(const GymPushtQuirks& quirks)
      : Simulator("gym-pusht", kGymStartTolerance, gymPusht()), world_(quirks) {}

  const gym_pusht::State* stateInPixels() const override { return &in_pixels_; }

 private:
  void doReset(const WorldState& state) override {
    world_.restore(gym_pusht::fromTable(state, world_.centerOfGravity()));
    standAt(state);
  }

  void doSpawn(const WorldState& start, std::uint64_t seed) override {
    if (world_.centerOfGravity() != gym_pusht::kCenterOfGravity) {
      doReset(start);  // a reset would turn this tee about another point than the spawn's
      return;
    }
    world_.reset(gym_pusht::drawn(static_cast<std::uint32_t>(seed)));
    standAt(start);
  }

  /// Remembers that the world is at `start`, in other bits.
  void standAt(const WorldState& start) {
    in_pixels_ = world_.state();
    requireStart(start, gym_pusht::toTable(in_pixels_, world_.centerOfGravity()), kGymStartTolerance);
    start_ = start;
  }

  void doStep(const Action& action) override {
    start_.reset();
    world_.step({action[0], action[1]});
    in_pixels_ = world_.state();
  }

  /// Until the first step it is the start's, so that a reset to it changes no bit.
  WorldState doState() const override {
    return start_ ? *start_ : gym_pusht::toTable(in_pixels_, world_.centerOfGravity());
  }

  GymPushtWorld world_;
  gym_pusht::State in_pixels_;
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
