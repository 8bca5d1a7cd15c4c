// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "audit/audit_run.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"
#include "sim2sim_eval/batch/batch_options.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/simulators.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_eval/policy_audit_run.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

namespace sim2sim {
namespace {

/// Command line of `audit`.
struct AuditOptions {
  std::string reference = kCourseReference;         ///< name of a kind
  std::vector<std::string> reference_parameters{};  ///< "NAME=VALUE", as for chooseSimulator()
  std::string engine = kCourseEngine;               ///< name of a kind
  std::vector<std::string> engine_parameters{};
  std::string against;     ///< "task": the engine alone, against the task's figures; empty: against the reference
  std::uint64_t seed = 0;  ///< moves the scenes of the experiments a little
  std::string task = pusht::fullCircle().name;
  int threads = 0;                       ///< 0: one for each core that the process may use
  std::filesystem::path out;             ///< JSON file to be written; empty: none
  bool overwrite = false;                ///< replace a file that is there already
  std::string policy;                    ///< audited in place of simulators; empty: none
  std::filesystem::path demonstrations;  ///< bag or CSV, for the policy
};

AuditedSimulator auditedOf(const LoadedSimulator& simulator) {
  return {simulator.record(), simulator.model.make_world, simulator.kind.departures};
}

/// Prints the audit and writes it. Throws ContractError if the contract is broken; InvalidInput for bad options or a
/// file that is there already; as chooseSimulator() and SimulatorKind::load.
void auditSimulators(const AuditOptions& options) {
  if (!options.overwrite) {
    pusht::requireNewFile("audit", options.out);
  }
  requireFits(pusht::taskNamed(options.task));
  const auto load = [&options](const std::string& kind, const std::vector<std::string>& settings) {
    SimulatorChoice choice = chooseSimulator(kind, settings);
    requireNoLoop(choice, "an audit");
    setTask(pusht::taskNamed(options.task), {choice});
    if (choice.foreign) {
      throw pusht::InvalidInput("simulator " + choice.name() + ": must be a kind: audit.launch audits nodes");
    }
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
    run.variants = variantsOf(reference->kind, reference->model.parameters, reference->task);
  }
  run.seed = options.seed;
  run.task = engine.task;
  run.threads = batch.threadCount();
  const Audit result = carryOut(run);
  report(run, result, options.out, options.overwrite);
  requireContract(result);
}

/// Prints the audit of the policy, and writes it. Throws ContractError if a fault explains its error; InvalidInput for
/// a file that is there already; as auditPolicyFile().
void auditPolicy(const AuditOptions& options) {
  if (!options.overwrite) {
    pusht::requireNewFile("audit", options.out);
  }
  PolicyAuditRun run = auditPolicyFile(options.policy, readDemonstrations(options.demonstrations));
  run.demonstrations = options.demonstrations.string();
  std::cout << run.text() << std::flush;
  if (!options.out.empty()) {
    options.overwrite ? pusht::writeFile(options.out, run.json())
                      : pusht::writeNewFile("audit", options.out, run.json());
  }
  if (run.audit.verdict == PolicyVerdict::kFault) {
    throw pusht::ContractError("the policy is asked wrongly: right with " + run.audit.fault());
  }
}

}  // namespace

int auditMain(int argc, char** argv) {
  AuditOptions options;
  CLI::App app("Says by experiments whether two simulators keep one contract, and in what physics they differ.",
               "audit");
  const std::string kinds = pusht::joined(pusht::SimulatorKinds::installed().names());
  app.add_option("--reference", options.reference, "kind of simulator: " + kinds)->capture_default_str();
  app.add_option("--engine", options.engine, "kind of simulator that is audited")->capture_default_str();
  app.add_option("--set", options.engine_parameters, "NAME=VALUE: a parameter of the engine; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--set-reference", options.reference_parameters,
                 "NAME=VALUE: a parameter of the reference; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--against", options.against, "'task': the engine alone, against the task's own figures")
      ->check(CLI::IsMember({kAgainstTask}))
      ->excludes("--reference")
      ->excludes("--set-reference");
  app.add_option("--seed", options.seed, "moves the scenes of the experiments by at most 2 mm")
      ->check(decimalInteger())
      ->capture_default_str();
  app.add_option("--task", options.task, "task in which the simulators are audited, as for `compare`")
      ->check(notEmpty())
      ->capture_default_str();
  app.add_option("--threads", options.threads, "number of threads; 0: one for each core")
      ->check(decimalInteger())
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--out", options.out, "write the audit into a new JSON file")->check(notEmpty());
  app.add_flag("--overwrite", options.overwrite, "replace a file that is there already");
  CLI::Option* const policy =
      app.add_option("--policy", options.policy, "audits a policy in place of simulators: a file or a name")
          ->check(notEmpty());
  CLI::Option* const demonstrations =
      app.add_option("--demonstrations", options.demonstrations,
                     "what the policy is asked: a bag of `demonstrate`, or a CSV of observations and actions")
          ->check(notEmpty());
  demonstrations->needs(policy);
  policy->needs(demonstrations);
  for (const char* of_simulators :
       {"--reference", "--engine", "--set", "--set-reference", "--against", "--seed", "--task", "--threads"}) {
    policy->excludes(app.get_option(of_simulators));
  }
  return runCommand(app, argc, argv, [&] { options.policy.empty() ? auditSimulators(options) : auditPolicy(options); });
}

}  // namespace sim2sim
