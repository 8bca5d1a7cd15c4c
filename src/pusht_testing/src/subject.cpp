// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_testing/subject.hpp"

#include <ostream>

namespace pusht::testing {

SimulatorModel Subject::load() const {
  ParameterSet parameters = kind.defaults();
  for (const auto& [name, text] : settings) {
    parameters.set(name, text);
  }
  return kind.load(parameters, task);
}

std::vector<Subject> idiomsOf(const SimulatorKind& kind) {
  std::vector<Subject> idioms = {{kind, {{"preset", "idiomatic"}}}};
  for (const ParameterDescriptor& parameter : kind.parameters) {
    if (parameter.default_value == ParameterValue(true)) {
      idioms.push_back({kind, {{parameter.name, "false"}}});
    }
  }
  return idioms;
}

void PrintTo(const Subject& subject, std::ostream* out) {  // NOLINT(readability-identifier-naming)
  *out << subject.kind.name;
  for (const auto& [name, text] : subject.settings) {
    *out << ' ' << name << '=' << text;
  }
}

}  // namespace pusht::testing
