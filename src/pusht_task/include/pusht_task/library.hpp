// SPDX-License-Identifier: BSD-3-Clause
/// Shared libraries that are loaded on demand.
#pragma once

#include <filesystem>
#include <string>

namespace pusht {

/// A shared library with all that it is linked to, in the process until that ends.
class Library {
 public:
  /// Other libraries find the symbols of a global one, too.
  enum class Scope { kLocal, kGlobal };

  /// Throws RuntimeFault where memory or open files are limited, else BadDependency: the library is missing, or one
  /// that it needs, or a symbol.
  explicit Library(const std::filesystem::path& path, Scope scope = Scope::kLocal);

  /// The object of type T that the library exports under that name; null if there is none.
  template <class T>
  const T* find(const std::string& symbol) const {
    return static_cast<const T*>(address(symbol));
  }

 private:
  const void* address(const std::string& symbol) const;

  void* handle_;
};

/// Whether a text of dlerror() says that there was too little memory, or that too many files are open. The dynamic
/// loader has many words for it, and not always those of errno.
bool isOfALimit(const std::string& text);

/// Version in the name of the file that a function or variable of this process was loaded from: "3.24" of libX.so.3.24.
/// Empty if the file says none.
std::string versionOfLibrary(const void* symbol);

}  // namespace pusht
