// SPDX-License-Identifier: BSD-3-Clause
#include "bullet_library.hpp"

#include <LinearMath/btAlignedAllocator.h>
#include <link.h>

#include <cstddef>
#include <string_view>

#include "pusht_task/error.hpp"
#include "pusht_task/library.hpp"

namespace pusht::bullet {
namespace {

/// Notes the name of a loaded library if it is Bullet's in single precision, and then ends the search.
int findSinglePrecision(dl_phdr_info* library, std::size_t /*size*/, void* found) {
  const std::string_view name = library->dlpi_name;
  const std::string_view file = name.substr(name.rfind('/') + 1);
  for (const std::string_view single : {"libLinearMath.so", "libBulletCollision.so", "libBulletDynamics.so"}) {
    if (file.substr(0, single.size()) == single) {
      *static_cast<std::string*>(found) = name;
      return 1;
    }
  }
  return 0;
}

}  // namespace

std::string libraryVersion() { return versionOfLibrary(reinterpret_cast<const void*>(&btAlignedAllocInternal)); }

void requireOneBuild() {
  std::string single;
  dl_iterate_phdr(findSinglePrecision, &single);
  if (!single.empty()) {
    throw BadDependency("library " + single +
                        ": must not be in a process with Bullet in double precision, which has the same symbols");
  }
}

}  // namespace pusht::bullet
