// SPDX-License-Identifier: BSD-3-Clause
#include "box2d_kind.hpp"

#include "box2d_world.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_task/simulator_plugin.hpp"
#include "pusht_task/substeps.hpp"

namespace pusht {
namespace {

using box2d::kSwitches;

constexpr const char* kVelocityIterations = "velocity_iterations";
constexpr const char* kPositionIterations = "position_iterations";
constexpr const char* kSubstepLength = "substep";

std::vector<ParameterDescriptor> describe() {
  const Box2dParameters defaults;
  std::vector<ParameterDescriptor> descriptors = mappingDescriptors(kSwitches);
  descriptors.push_back({kVelocityIterations, "", "sweeps over velocities in a substep",
                         std::int64_t{defaults.velocity_iterations}, 1, 1000,
                         "more sweeps make no visible difference"});
  descriptors.push_back({kPositionIterations, "", "most sweeps over overlaps in a substep",
                         std::int64_t{defaults.position_iterations}, 1, 1000,
                         "more sweeps make no visible difference"});
  descriptors.push_back(substepDescriptor(kSubstepLength));
  return descriptors;
}

SimulatorModel load(const ParameterSet& parameters) {
  Box2dParameters chosen;
  chosen.velocity_iterations = static_cast<int>(parameters.get<std::int64_t>(kVelocityIterations));
  chosen.position_iterations = static_cast<int>(parameters.get<std::int64_t>(kPositionIterations));
  chosen.substep = parameters.get<double>(kSubstepLength);
  readSwitches(parameters, kSwitches, chosen.switches);
  return modelOfWorlds(parameters, [chosen] { return std::make_unique<Box2dWorld>(chosen); });
}

}  // namespace

const SimulatorKind& box2dKind() {
  static const SimulatorKind kind = {"box2d",    "Box2D",           box2dVersion(),
                                     describe(), {"libbox2d.so"},   Box2dWorld::kStartTolerance,
                                     load,       {"substep=0.005"}, {"overlap"}};  // its contacts are Box2D's own
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(box2d, pusht::box2dKind);
