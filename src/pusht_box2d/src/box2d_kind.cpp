// SPDX-License-Identifier: BSD-3-Clause
#include "box2d_kind.hpp"

#include <mutex>

#include "box2d_scene.hpp"
#include "pusht_task/library.hpp"
#include "pusht_task/scene_kind.hpp"
#include "pusht_task/simulator_plugin.hpp"

namespace pusht {
namespace {

/// Version of the library as loaded, e.g. "2.4.1".
std::string versionOfBox2d() {
  // Its own variable b2_version still says 2.4.0 in 2.4.1; the name of its file is right.
  const std::string version = versionOfLibrary(reinterpret_cast<const void*>(&b2Alloc_Default));
  return !version.empty() ? version
                          : std::to_string(b2_version.major) + "." + std::to_string(b2_version.minor) + "." +
                                std::to_string(b2_version.revision);
}

/// Box2D fills a table of contacts at the first contact of a process, without a lock.
void fillTableOfContacts() {
  static std::once_flag done;
  std::call_once(done, [] {
    WorldState touching;
    touching.pusher_position = touching.tee_position;
    Box2dScene first{Box2dParameters()};
    first.start(touching);
    first.substep({0.0, 0.0});
  });
}

}  // namespace

const SimulatorKind& box2dKind() {
  static const SimulatorKind kind =
      kindOfScenes<Box2dScene>("box2d", versionOfBox2d(), {"libbox2d.so"}, fillTableOfContacts);
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(box2d, pusht::box2dKind);
