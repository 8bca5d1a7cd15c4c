// SPDX-License-Identifier: BSD-3-Clause
/// The GIL, and the end of the interpreter.
#pragma once

#include <pybind11/pybind11.h>

#include <optional>

namespace sim2sim::python {

/// Releases the GIL for its life, as pybind11::gil_scoped_release does. Where the interpreter ends meanwhile, Python
/// would kill the thread as it takes the GIL back, in the middle of C++, which ends the process: here it stays for ever
/// instead, and the process ends without it.
class WithoutGil {
 public:
  WithoutGil();
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;
  ~WithoutGil();

 private:
  std::optional<pybind11::gil_scoped_release> released_;  // none once the interpreter ends
};

/// Waits for the threads that are without the GIL; from now on none releases it. For the interpreter's end.
void endWithoutGil();

}  // namespace sim2sim::python
