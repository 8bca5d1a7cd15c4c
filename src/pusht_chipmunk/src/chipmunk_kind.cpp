// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_chipmunk/chipmunk_kind.hpp"

#include "pusht_chipmunk/chipmunk_world.hpp"
#include "pusht_task/simulator_plugin.hpp"
#include "pusht_task/substeps.hpp"

namespace pusht {
namespace {

constexpr const char* kIterations = "iterations";
constexpr const char* kSlop = "collision_slop";
constexpr const char* kOverlapLeft = "overlap_left";
constexpr const char* kSubstepLength = "substep";

SimulatorModel load(const ParameterSet& parameters) {
  const ChipmunkParameters chosen = {static_cast<int>(parameters.get<std::int64_t>(kIterations)),
                                     parameters.get<double>(kSlop), parameters.get<double>(kOverlapLeft),
                                     parameters.get<double>(kSubstepLength)};
  return modelOfWorlds(parameters, [chosen] { return std::make_unique<ChipmunkWorld>(chosen); });
}

}  // namespace

const SimulatorKind& chipmunkKind() {
  const ChipmunkParameters defaults;
  static const SimulatorKind kind = {
      "chipmunk",
      "Chipmunk",
      chipmunkVersion(),
      {{kIterations, "", "sweeps of the contact solver in a substep", std::int64_t{defaults.iterations}, 1, 1000,
        "more sweeps make no visible difference"},
       {kSlop, "m", "overlap that the solver leaves alone", defaults.collision_slop, 0.0, 0.01,
        "more is a third of the tee's width"},
       {kOverlapLeft, "", "share of an overlap that is left after a second", defaults.overlap_left, 0.0, 1.0,
        "it is a share"},
       substepDescriptor(kSubstepLength)},
      {"libchipmunk.so"},
      ChipmunkWorld::kStartTolerance,
      load,
      {"substep=0.005"},
      {"overlap"}};  // its contacts are Chipmunk's own
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(chipmunk, pusht::chipmunkKind);
