// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/audit.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
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
#include "sim2sim_eval/batch/audited_pair.hpp"
#include "sim2sim_eval/batch/batch_options.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/simulators.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/model_variants.hpp"

namespace sim2sim {
namespace {

constexpr const char* kTask = "task";

/// Title of a simulator, or, where it has parameters of its own, the text that asks for it.
std::string titleOf(const LoadedSimulator& simulator) {
  const std::string text = textOf({simulator.kind, simulator.model.parameters});
  return text == simulator.kind.name ? simulator.kind.title : text;
}

AuditedWorld worldOf(const LoadedSimulator& simulator) {
  return {titleOf(simulator), simulator.model.make_world, true, simulator.kind.departures};
}

/// The reference with other numerics, as its kind lists them.
std::vector<AuditedWorld> variantsOf(const LoadedSimulator& reference) {
  std::vector<AuditedWorld> variants;
  for (const LoadedVariant& variant : loadDefaultVariants(reference.kind, reference.model.parameters)) {
    variants.push_back({variant.name, variant.model.make_world});
  }
  return variants;
}

Audit auditAgainstReference(const AuditOptions& options, const LoadedSimulator& reference,
                            const LoadedSimulator& engine) {
  BatchOptions batch;
  batch.threads = options.threads;
  pusht::ScriptedExpert expert;
  return audit(worldOf(reference), worldOf(engine), variantsOf(reference), options.seed, batch.threadCount(), &expert);
}

/// Keeps the verdict for `compare`. An audit says the same where nothing can be written, so that is a warning.
void keepVerdict(const Audit& audit, const KeptVerdict& kept) {
  std::vector<std::string> contract_errors;
  for (const Comparison& finding : audit.findings()) {
    if (finding.isContractError()) {
      contract_errors.emplace_back(describe(finding.property).title);
    }
  }
  try {
    kept.keep(contract_errors);
  } catch (const pusht::RuntimeFault& fault) {
    warn(std::string("the verdict is not kept, so compare will not know it: ") + fault.what());
  }
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
  const LoadedSimulator engine(chooseSimulator(options.engine, options.engine_parameters));
  std::optional<LoadedSimulator> reference;
  if (options.against.empty()) {
    reference.emplace(chooseSimulator(options.reference, options.reference_parameters));
  }
  const Audit result =
      reference ? auditAgainstReference(options, *reference, engine) : auditAgainstTask(worldOf(engine), options.seed);
  requireNotInterrupted();
  std::cout << textOf(result);
  if (!options.out.empty()) {
    const auto record = reference ? std::optional(reference->record()) : std::nullopt;
    pusht::writeFile(options.out, auditText(toJson(result), record, engine.record()));
  }
  if (reference) {
    keepVerdict(result, keptVerdict(*reference, engine));
  }
  if (result.hasContractErrors()) {
    throw pusht::ContractError("the contract is broken: " + causeOf(result.findings().front()));
  }
}

}  // namespace sim2sim
