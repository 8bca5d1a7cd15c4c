// SPDX-License-Identifier: BSD-3-Clause
#include "audit/audit_run.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "pusht_policy/scripted_expert.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "sim2sim_audit/audit_json.hpp"
#include "sim2sim_audit/task_figures.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/model_variants.hpp"
#include "sim2sim_protocol/results/result_files.hpp"

namespace sim2sim {
namespace {

/// World that is lost once the process is interrupted, so that no further experiment begins.
class Interruptible : public pusht::Simulator {
 public:
  explicit Interruptible(std::unique_ptr<pusht::Simulator> world)
      : Simulator("", world->startTolerance(), world->task()), world_(std::move(world)) {}

 private:
  void doReset(const pusht::WorldState& state) override {
    requireGoingOn();
    world_->reset(state);
  }
  void doStep(const pusht::Action& action) override {
    requireGoingOn();
    world_->step(action);
  }
  pusht::WorldState doState() const override { return world_->state(); }

  static void requireGoingOn() {
    if (interrupted()) {
      throw WorldLost("interrupted");
    }
  }

  std::unique_ptr<pusht::Simulator> world_;
};

AuditedWorld interruptible(AuditedWorld world) {
  world.make = [make = world.make] { return std::make_unique<Interruptible>(make()); };
  return world;
}

AuditedWorld worldOf(const AuditedSimulator& simulator) {
  return interruptible({titleOf(simulator.record), simulator.make, simulator.departures});
}

Audit auditOf(const AuditRun& run) {
  if (!run.reference) {
    return auditAgainstTask(worldOf(run.engine), run.seed);
  }
  std::vector<AuditedWorld> variants;
  std::transform(run.variants.begin(), run.variants.end(), std::back_inserter(variants), interruptible);
  pusht::ScriptedExpert expert(run.task);
  return audit(worldOf(*run.reference), worldOf(run.engine), variants, run.seed, run.threads, &expert);
}

/// Text of audit.json: the audit, with the number of the format, and with both simulators as metrics.json names them.
std::string fileText(const AuditRun& run, const Audit& audit) {
  constexpr int kIndent = 2;
  nlohmann::ordered_json file = {{"format", kAuditFormat}};
  file.update(toJson(audit));
  file["simulators"] = {{"reference", run.reference ? toJson(run.reference->record) : nlohmann::ordered_json()},
                        {"engine", toJson(run.engine.record)}};
  return file.dump(kIndent) + "\n";
}

}  // namespace

std::vector<AuditedWorld> variantsOf(const pusht::SimulatorKind& kind, const pusht::ParameterSet& parameters,
                                     const pusht::Task& task) {
  std::vector<AuditedWorld> variants;
  for (const LoadedVariant& variant : loadDefaultVariants(kind, parameters, task)) {
    variants.push_back({variant.name, variant.model.make_world});
  }
  return variants;
}

void requireFits(const pusht::Task& task) {
  const pusht::Physics course;
  const pusht::Physics& physics = task.physics;
  const auto reach = [](const pusht::Physics& of) { return of.stem_offset + of.stem_half_length; };
  const bool is_small = physics.bar_half_length <= course.bar_half_length && reach(physics) <= reach(course);
  const bool is_in_middle = std::hypot(physics.wall_middle[0], physics.wall_middle[1]) < Bench::kShift;
  const bool has_usual_limit = task.action_limit.value_or(pusht::kActionLimit) == pusht::kActionLimit;
  if (!is_small || !is_in_middle || !has_usual_limit) {
    throw pusht::InvalidInput("task " + task.name +
                              ": must have a tee no larger than full_circle's, walls around the origin, and its "
                              "action_limit or none: an audit's experiments are made for these");
  }
}

Audit carryOut(const AuditRun& run) {
  Audit result = auditOf(run);
  requireNotInterrupted();
  return result;
}

void report(const AuditRun& run, const Audit& audit, const std::filesystem::path& out, bool overwrite) {
  std::cout << textOf(audit) << std::flush;
  if (!out.empty()) {
    const std::string text = fileText(run, audit);
    overwrite ? pusht::writeFile(out, text) : pusht::writeNewFile("audit", out, text);
  }
}

void requireContract(const Audit& audit) {
  if (audit.hasContractErrors()) {
    throw pusht::ContractError("the contract is broken: " + causeOf(audit.findings().front()));
  }
}

}  // namespace sim2sim
