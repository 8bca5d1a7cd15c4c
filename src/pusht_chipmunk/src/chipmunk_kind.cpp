// SPDX-License-Identifier: BSD-3-Clause
#include "chipmunk_kind.hpp"

#include "chipmunk_scene.hpp"
#include "chipmunk_types.hpp"
#include "pusht_task/scene_kind.hpp"
#include "pusht_task/simulator_plugin.hpp"

namespace pusht {

const SimulatorKind& chipmunkKind() {
  static const SimulatorKind kind = kindOfScenes<ChipmunkScene>("chipmunk", cpVersionString, {"libchipmunk.so"},
                                                                prepareChipmunk, ParameterOrder::kNumbersFirst);
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(chipmunk, pusht::chipmunkKind);
