// SPDX-License-Identifier: BSD-3-Clause
/// Long forms of tests, which repeat an experiment over more seeds, kinds or episodes than every run has time for.
#pragma once

#include <cstdlib>

namespace pusht::testing {

/// Whether they run: `script/test --long` sets PUSHT_LONG_TESTS.
inline bool longTests() { return std::getenv("PUSHT_LONG_TESTS") != nullptr; }

}  // namespace pusht::testing
