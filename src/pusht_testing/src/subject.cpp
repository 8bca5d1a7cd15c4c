// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_testing/subject.hpp"

#include <ostream>

namespace pusht::testing {

SimulatorModel Subject::load() const {
  ParameterSet parameters = kind.defaults();
  for (const auto& [name, text] : settings) {
    parameters.set(name, text);
  }
  return kind.load(parameters);
}

void PrintTo(const Subject& subject, std::ostream* out) {  // NOLINT(readability-identifier-naming)
  *out << subject.kind.name;
  for (const auto& [name, text] : subject.settings) {
    *out << ' ' << name << '=' << text;
  }
}

}  // namespace pusht::testing
