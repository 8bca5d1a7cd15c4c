// SPDX-License-Identifier: BSD-3-Clause
#include "batch/audit.hpp"

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "audit/audit_run.hpp"
#include "batch/audited_pair.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"
#include "sim2sim_eval/batch/batch_options.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/simulators.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

namespace sim2sim {
namespace {

AuditedSimulator auditedOf(const LoadedSimulator& simulator) {
  return {simulator.record(), simulator.model.make_world, simulator.kind.departures};
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
      ->check(CLI::IsMember({kAgainstTask}))
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
    pusht::requireNewFile("audit", options.out);
  }
  const auto load = [](const std::string& kind, const std::vector<std::string>& settings) {
    const SimulatorChoice choice = chooseSimulator(kind, settings);
    requireNoLoop(choice, "an audit");
    return LoadedSimulator(choice);
  };
  const LoadedSimulator engine = load(options.engine, options.engine_parameters);
  std::optional<LoadedSimulator> reference;
  if (options.against.empty()) {
    reference.emplace(load(options.reference, options.reference_parameters));
  }
  BatchOptions batch;
  batch.threads = options.threads;
  AuditRun run;
  run.engine = auditedOf(engine);
  if (reference) {
    run.reference = auditedOf(*reference);
    run.variants = variantsOf(reference->kind, reference->model.parameters);
  }
  run.seed = options.seed;
  run.threads = batch.threadCount();
  const Audit result = carryOut(run);
  report(run, result, options.out, options.overwrite);
  if (reference) {
    keepVerdict(result, keptVerdict(*reference, engine));
  }
  requireContract(result);
}

}  // namespace sim2sim
