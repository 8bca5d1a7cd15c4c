// SPDX-License-Identifier: BSD-3-Clause
#include "bullet_kind.hpp"

#include "bullet_library.hpp"
#include "bullet_scene.hpp"
#include "pusht_task/scene_kind.hpp"
#include "pusht_task/simulator_plugin.hpp"

namespace pusht {

const SimulatorKind& bulletKind() {
  static const SimulatorKind kind = kindOfScenes<BulletScene>(
      "bullet", bullet::libraryVersion(),
      {"libBulletDynamics-float64.so", "libBulletCollision-float64.so", "libLinearMath-float64.so"},
      bullet::requireOneBuild);
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(bullet, pusht::bulletKind);
