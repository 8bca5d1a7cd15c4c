// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/audit.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_policy/scripted_expert.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/ros/simulator_kinds.hpp"
#include "sim2sim_audit/audit.hpp"
#include "sim2sim_audit/audit_json.hpp"
#include "sim2sim_audit/task_figures.hpp"
#include "sim2sim_eval/batch/batch_options.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/simulators.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/model_variants.hpp"

namespace sim2sim {
namespace {

constexpr const char* kTask = "task";

/// Title of a simulator, or, where it has parameters of its own, the text that asks for it.
std::string titleOf(const SimulatorChoice& choice) {
  const pusht::SimulatorKind& kind = choice.kind;
  const std::string text = textOf(choice);
  return text == kind.name ? kind.title : text;
}

AuditedWorld worldOf(const SimulatorChoice& choice) {
  return {titleOf(choice), LoadedSimulator(choice).model.make_world, true, choice.kind.get().departures};
}

/// The reference with other numerics, as its kind lists them.
std::vector<AuditedWorld> variantsOf(const SimulatorChoice& reference) {
  std::vector<AuditedWorld> variants;
  for (const LoadedVariant& variant : loadDefaultVariants(reference.kind, reference.parameters)) {
    variants.push_back({variant.name, variant.model.make_world});
  }
  return variants;
}

Audit auditAgainstReference(const AuditOptions& options, const SimulatorChoice& engine) {
  const SimulatorChoice reference = chooseSimulator(options.reference, options.reference_parameters);
  BatchOptions batch;
  batch.threads = options.threads;
  pusht::ScriptedExpert expert;
  return audit(worldOf(reference), worldOf(engine), variantsOf(reference), options.seed, batch.threadCount(), &expert);
}

}  // namespace

void AuditOptions::declare(CLI::App& app) {
  const std::string kinds = pusht::joined(pusht::SimulatorKinds::installed().names());
  app.add_option("--reference", reference, "kind of simulator: " + kinds)->capture_default_str();
  app.add_option("--engine", engine, "kind of simulator that is audited")->capture_default_str();
  app.add_option("--set", engine_parameters, "NAME=VALUE: a parameter of the engine; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--set-reference", reference_parameters, "NAME=VALUE: a parameter of the reference; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--against", against, "'task': the engine alone, against the task's own figures")
      ->check(CLI::IsMember({kTask}))
      ->excludes("--reference")
      ->excludes("--set-reference");
  app.add_option("--seed", seed, "moves the scenes of the experiments by at most 2 mm")
      ->check(decimalInteger())
      ->capture_default_str();
  app.add_option("--threads", threads, "number of threads; 0: one for each core")
      ->check(decimalInteger())
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--out", out, "write the audit into a new JSON file")->check(notEmpty());
  app.add_flag("--overwrite", overwrite, "replace a file that is there already");
}

void auditSimulators(const AuditOptions& options) {
  if (!options.overwrite) {
    requireNewFile("audit", options.out);
  }
  const SimulatorChoice engine = chooseSimulator(options.engine, options.engine_parameters);
  const Audit result = options.against.empty()
                           ? auditAgainstReference(options, engine)
                           : auditAgainstTask(worldOf(engine), options.seed);
  requireNotInterrupted();
  std::cout << textOf(result);
  if (!options.out.empty()) {
    pusht::writeFile(options.out, toJson(result).dump(2) + "\n");
  }
  if (result.hasContractErrors()) {
    throw pusht::ContractError("the contract is broken: " + causeOf(result.findings().front()));
  }
}

}  // namespace sim2sim
