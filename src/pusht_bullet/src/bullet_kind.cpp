// SPDX-License-Identifier: BSD-3-Clause
#include "bullet_kind.hpp"

#include "bullet_library.hpp"
#include "bullet_world.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_task/simulator_plugin.hpp"
#include "pusht_task/substeps.hpp"

namespace pusht {
namespace {

using bullet::kSwitches;

constexpr const char* kIterations = "iterations";
constexpr const char* kOverlapRate = "overlap_rate";
constexpr const char* kSubstepLength = "substep";

std::vector<ParameterDescriptor> describeBullet() {
  const BulletParameters defaults;
  std::vector<ParameterDescriptor> descriptors = mappingDescriptors(kSwitches);
  descriptors.push_back({kIterations, "", "sweeps of the constraint solver in a substep",
                         std::int64_t{defaults.iterations}, 1, 1000, "more sweeps make no visible difference"});
  descriptors.push_back({kOverlapRate, "1/s", "rate at which overlaps go away", defaults.overlap_rate, 0.0, 100.0,
                         "a substep of 0.01 s then takes all of it away"});
  descriptors.push_back(substepDescriptor(kSubstepLength));
  return descriptors;
}

SimulatorModel load(const ParameterSet& parameters) {
  bullet::requireOneBuild();
  BulletParameters values;
  readSwitches(parameters, kSwitches, values);
  values.iterations = static_cast<int>(parameters.get<std::int64_t>(kIterations));
  values.overlap_rate = parameters.get<double>(kOverlapRate);
  values.substep = parameters.get<double>(kSubstepLength);
  return modelOfWorlds(parameters, [values] { return std::make_unique<BulletWorld>(values); });
}

}  // namespace

const SimulatorKind& bulletKind() {
  static const SimulatorKind kind = {
      "bullet",
      "Bullet",
      bullet::libraryVersion(),
      describeBullet(),
      {"libBulletDynamics-float64.so", "libBulletCollision-float64.so", "libLinearMath-float64.so"},
      BulletWorld::kStartTolerance,
      load,
      {"substep=0.005"},
      {"overlap"}};  // its contacts are Bullet's own
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(bullet, pusht::bulletKind);
