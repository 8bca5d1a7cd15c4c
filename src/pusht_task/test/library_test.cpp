// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/library.hpp"

#include <gtest/gtest.h>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

/// Texts as dlerror() had them under `ulimit -v` and `ulimit -n`, and others of which the library is to blame.
TEST(Libraries, LimitsAreToldFromLibrariesThatAreAtFault) {
  for (const char* text : {"libleveldb.so.1d: cannot create shared object descriptor",
                           "libtorch.so: failed to map segment from shared object",
                           "libtorch.so: cannot allocate memory in static TLS block",
                           "libtorch.so: failed to map segment from shared object: Cannot allocate memory",
                           "libc10.so: cannot create shared object descriptor: Cannot allocate memory",
                           "libc10.so: cannot allocate version reference table",
                           "libc10.so: cannot open shared object file: Too many open files"}) {
    EXPECT_TRUE(isOfALimit(text)) << text;
  }
  for (const char* text : {"libc10.so: cannot open shared object file: No such file or directory",
                           "/lib/libpusht_toy.so: undefined symbol: _ZN5pusht3toyEv", "./mine.so: invalid ELF header",
                           "mine.so: file too short"}) {
    EXPECT_FALSE(isOfALimit(text)) << text;
  }
}

TEST(Libraries, ThatAreMissingAreABadDependency) { EXPECT_THROW(Library("/nowhere/libnothing.so"), BadDependency); }

}  // namespace
}  // namespace pusht
