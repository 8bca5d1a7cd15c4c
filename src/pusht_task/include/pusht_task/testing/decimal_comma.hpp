// SPDX-License-Identifier: BSD-3-Clause
/// Locale with a decimal comma: 6,5 and 1.000.000.
#pragma once

#include <array>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <locale>
#include <stdexcept>
#include <string>

#include "pusht_task/testing/temporary_folder.hpp"

namespace pusht::testing {

/// While it lives, the process has that locale, in C and in C++. It is made for it: few machines have one installed.
/// Throws if a C function would still write a point: what is tested then would show nothing.
class DecimalComma {
 public:
  DecimalComma() {
    const std::string name = "de_DE.UTF-8";
    const std::string make = "localedef -i de_DE -f UTF-8 " + (folder_ / name).string();
    static_cast<void>(std::system(make.c_str()));  // NOLINT(cert-env33-c): no text of others is in it
    ::setenv("LOCPATH", folder_.path().c_str(), 1);
    std::setlocale(LC_ALL, name.c_str());
    std::locale::global(std::locale(std::locale::classic(), new Comma));  // std::locale(name) leaks, in glibc
    std::array<char, 8> text{};
    static_cast<void>(std::snprintf(text.data(), text.size(), "%.1f", 6.5));
    if (std::string(text.data()) != "6,5") {
      throw std::runtime_error(name + " writes 6,5 as " + text.data());
    }
  }
  DecimalComma(const DecimalComma&) = delete;
  DecimalComma& operator=(const DecimalComma&) = delete;
  ~DecimalComma() {
    std::locale::global(before_);
    std::setlocale(LC_ALL, before_c_.c_str());
    ::unsetenv("LOCPATH");
  }

 private:
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };

  const TemporaryFolder folder_;
  const std::string before_c_ = std::setlocale(LC_ALL, nullptr);
  const std::locale before_;
};

}  // namespace pusht::testing
