// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/library.hpp"

#include <dlfcn.h>

#include "pusht_task/error.hpp"

namespace pusht {

Library::Library(const std::filesystem::path& path, Scope scope)
    : handle_(dlopen(path.c_str(), RTLD_NOW | (scope == Scope::kGlobal ? RTLD_GLOBAL : RTLD_LOCAL))) {
  if (handle_ != nullptr) {
    return;
  }
  const std::string message = "library " + path.string() + ": cannot be loaded: " + dlerror();
  for (const char* limit : {"allocate memory", "failed to map segment", "Too many open files"}) {
    if (message.find(limit) != std::string::npos) {
      throw RuntimeFault(message);
    }
  }
  throw BadDependency(message);
}

const void* Library::address(const std::string& symbol) const { return dlsym(handle_, symbol.c_str()); }

}  // namespace pusht
