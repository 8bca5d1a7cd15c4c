// SPDX-License-Identifier: BSD-3-Clause
/// Numbers as text, and rounded, the way Python does it; independent of the locale.
#pragma once

#include <string>

namespace pusht {

/// The shortest text that reads back as `value`, as Python's repr() writes it: 4.0, 0.1, 1e-05, 1e+16.
std::string shortestText(double value);

/// `value` with `digits` digits after the point, correctly rounded: 0.082000.
std::string fixedText(double value, int digits);

/// The double nearest to `value` rounded to six decimals, as Python's round(value, 6).
double roundToMicro(double value);

}  // namespace pusht
