// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_testing/decimal_comma.hpp"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

namespace pusht::testing {
namespace {

struct Comma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

}  // namespace

DecimalComma::DecimalComma() {
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

DecimalComma::~DecimalComma() {
  std::locale::global(before_);
  std::setlocale(LC_ALL, before_c_.c_str());
  ::unsetenv("LOCPATH");
}

}  // namespace pusht::testing
