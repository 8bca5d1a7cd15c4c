// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/library.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>

#include "pusht_task/error.hpp"

namespace pusht {

Library::Library(const std::filesystem::path& path, Scope scope)
    : handle_(dlopen(path.c_str(), RTLD_NOW | (scope == Scope::kGlobal ? RTLD_GLOBAL : RTLD_LOCAL))) {
  if (handle_ != nullptr) {
    return;
  }
  const std::string reason = dlerror();
  const std::string message = "library " + path.string() + ": cannot be loaded: " + reason;
  if (isOfALimit(reason)) {
    throw RuntimeFault(message);
  }
  throw BadDependency(message);
}

const void* Library::address(const std::string& symbol) const { return dlsym(handle_, symbol.c_str()); }

bool isOfALimit(const std::string& text) {
  // Source: dl-load.c, dl-open.c, dl-deps.c, dl-version.c, dl-tls.c of glibc 2.36 and 2.41.
  constexpr std::array kWords = {
      "annot allocate",        "cannot create", "cannot extend global scope",       "cannot map zero-fill pages",
      "failed to map segment", "out of memory", "cannot change memory protections", "Too many open files"};
  return std::any_of(kWords.begin(), kWords.end(),
                     [&text](const char* words) { return text.find(words) != std::string::npos; });
}

std::string versionOfLibrary(const void* symbol) {
  Dl_info info = {};
  if (dladdr(symbol, &info) == 0 || info.dli_fname == nullptr) {
    return "";
  }
  std::error_code unreadable;
  const std::string file = std::filesystem::canonical(info.dli_fname, unreadable).filename();
  constexpr std::string_view kExtension = ".so.";
  const std::size_t extension = file.rfind(kExtension);
  return extension == std::string::npos ? "" : file.substr(extension + kExtension.size());
}

}  // namespace pusht
