// SPDX-License-Identifier: BSD-3-Clause
// A library that needs a symbol which no library has.
namespace pusht {
struct SimulatorKind;
}

// NOLINTBEGIN(readability-identifier-naming): names of C
extern "C" const pusht::SimulatorKind& pusht_nowhere();
extern "C" const pusht::SimulatorKind& pusht_needs_it() { return pusht_nowhere(); }
// NOLINTEND(readability-identifier-naming)
