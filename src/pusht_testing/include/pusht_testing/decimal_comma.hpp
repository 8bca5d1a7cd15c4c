// SPDX-License-Identifier: BSD-3-Clause
/// Locale with a decimal comma: 6,5 and 1.000.000.
#pragma once

#include <clocale>
#include <locale>
#include <string>

#include "pusht_testing/temporary_folder.hpp"

namespace pusht::testing {

/// While it lives, the process has that locale, in C and in C++. It is made for it: few machines have one installed.
class DecimalComma {
 public:
  /// Throws if a C function would still write a point: what is tested then would show nothing.
  DecimalComma();
  DecimalComma(const DecimalComma&) = delete;
  DecimalComma& operator=(const DecimalComma&) = delete;
  ~DecimalComma();

 private:
  const TemporaryFolder folder_;
  const std::string before_c_ = std::setlocale(LC_ALL, nullptr);
  const std::locale before_;
};

}  // namespace pusht::testing
