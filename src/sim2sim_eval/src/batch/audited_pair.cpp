// SPDX-License-Identifier: BSD-3-Clause
#include "batch/audited_pair.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "pusht_task/joined.hpp"
#include "sim2sim_protocol/results/provenance.hpp"

namespace sim2sim {
namespace {

/// `text` as one word of a shell.
std::string shellWord(const std::string& text) {
  constexpr const char* kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_=.,/:+-@%";
  if (text.find_first_not_of(kPlain) == std::string::npos) {
    return text;
  }
  std::string word = "'";
  for (const char character : text) {
    word += character == '\'' ? "'\\''" : std::string(1, character);
  }
  return word + "'";
}

/// Options that choose a simulator: " --engine two_mass --set block_damp=20.0".
std::string optionsOf(const char* role, const char* setting, const LoadedSimulator& simulator) {
  std::string options = std::string(" ").append(role).append(" ").append(shellWord(simulator.kind.name));
  for (const std::string& text : settingsOf({simulator.kind, simulator.model.parameters})) {
    options.append(" ").append(setting).append(" ").append(shellWord(text));
  }
  return options;
}

/// "2 errors of the contract (delay of actions; noise)"; the worst three by name.
std::string textOf(const std::vector<std::string>& contract_errors) {
  constexpr std::size_t kMostNamed = 3;
  const auto named = static_cast<std::ptrdiff_t>(std::min(kMostNamed, contract_errors.size()));
  const std::string names = pusht::joined(std::vector(contract_errors.begin(), contract_errors.begin() + named), "; ");
  return std::to_string(contract_errors.size()) + (contract_errors.size() == 1 ? " error" : " errors") +
         " of the contract (" + names + (contract_errors.size() > kMostNamed ? "; ..." : "") + ")";
}

}  // namespace

KeptVerdict keptVerdict(const LoadedSimulator& reference, const LoadedSimulator& engine) {
  std::vector<std::string> libraries = {"libm.so", "libpusht_task.so", "libsim2sim_audit.so"};
  for (const LoadedSimulator* simulator : {&reference, &engine}) {
    libraries.insert(libraries.end(), simulator->kind.libraries.begin(), simulator->kind.libraries.end());
  }
  return {kAuditsFolder,
          {{"reference", toJson(reference.simulatorRecord())},
           {"engine", toJson(engine.simulatorRecord())},
           {"code", codeFingerprint(libraries)}}};
}

std::string auditCommand(const LoadedSimulator& reference, const LoadedSimulator& engine) {
  return "rosrun sim2sim_eval audit" + optionsOf("--reference", "--set-reference", reference) +
         optionsOf("--engine", "--set", engine);
}

std::string auditNote(const LoadedSimulator& reference, const LoadedSimulator& engine) {
  const std::optional<std::vector<std::string>> contract_errors = keptVerdict(reference, engine).find();
  if (!contract_errors) {
    return "not audited: " + auditCommand(reference, engine) + "\n";
  }
  if (contract_errors->empty()) {
    return "";
  }
  return "audited: " + textOf(*contract_errors) + "; " + auditCommand(reference, engine) + " shows " +
         (contract_errors->size() == 1 ? "it" : "them") + "\n";
}

}  // namespace sim2sim
