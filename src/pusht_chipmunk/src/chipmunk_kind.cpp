// SPDX-License-Identifier: BSD-3-Clause
#include "chipmunk_kind.hpp"

#include <utility>

#include "chipmunk_world.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_task/simulator_plugin.hpp"
#include "pusht_task/substeps.hpp"

namespace pusht {
namespace {

using chipmunk::kSwitches;

constexpr const char* kIterations = "iterations";
constexpr const char* kSlop = "collision_slop";
constexpr const char* kOverlapLeft = "overlap_left";
constexpr const char* kSubstepLength = "substep";

std::vector<ParameterDescriptor> describeChipmunk() {
  const ChipmunkParameters defaults;
  std::vector<ParameterDescriptor> descriptors = {
      {kIterations, "", "sweeps of the contact solver in a substep", std::int64_t{defaults.iterations}, 1, 1000,
       "more sweeps make no visible difference"},
      {kSlop, "m", "overlap that the solver leaves alone", defaults.collision_slop, 0.0, 0.01,
       "more is a third of the tee's width"},
      {kOverlapLeft, "", "share of an overlap that is left after a second", defaults.overlap_left, 0.0, 1.0,
       "it is a share"},
      substepDescriptor(kSubstepLength)};
  for (ParameterDescriptor& each : mappingDescriptors(kSwitches)) {
    descriptors.push_back(std::move(each));
  }
  return descriptors;
}

SimulatorModel load(const ParameterSet& parameters) {
  ChipmunkParameters chosen;
  chosen.iterations = static_cast<int>(parameters.get<std::int64_t>(kIterations));
  chosen.collision_slop = parameters.get<double>(kSlop);
  chosen.overlap_left = parameters.get<double>(kOverlapLeft);
  chosen.substep = parameters.get<double>(kSubstepLength);
  readSwitches(parameters, kSwitches, chosen.switches);
  return modelOfWorlds(parameters, [chosen] { return std::make_unique<ChipmunkWorld>(chosen); });
}

}  // namespace

const SimulatorKind& chipmunkKind() {
  static const SimulatorKind kind = {"chipmunk",
                                     "Chipmunk",
                                     chipmunkVersion(),
                                     describeChipmunk(),
                                     {"libchipmunk.so"},
                                     ChipmunkWorld::kStartTolerance,
                                     load,
                                     {"substep=0.005"},
                                     {"overlap"}};  // its contacts are Chipmunk's own
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(chipmunk, pusht::chipmunkKind);
