// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/loaded_run.hpp"

#include "pusht_task/error.hpp"
#include "pusht_task/task.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/flight.hpp"
#include "sim2sim_protocol/model_variants.hpp"
#include "sim2sim_protocol/results/provenance.hpp"
#include "sim2sim_serving/installed_file.hpp"

namespace sim2sim {
namespace {

/// Libraries that compute a rollout, besides those of the simulators and of the policy.
const std::vector<std::string> kLibraries = {"libm.so", "libpusht_task.so", "libpusht_policy.so",
                                             "libsim2sim_protocol.so"};

/// Fingerprint of the code of simulators and policy; what a foreign kind says of its own, under its name.
nlohmann::json codeOf(const std::vector<SimulatorChoice>& simulators, const pusht::ChosenPolicy& policy) {
  std::vector<std::string> libraries = kLibraries;
  for (const SimulatorChoice& simulator : simulators) {
    const std::vector<std::string>& of_kind = simulator.kind.get().libraries;
    libraries.insert(libraries.end(), of_kind.begin(), of_kind.end());
  }
  nlohmann::json code = codeFingerprint(libraries, policy.libraries);
  for (const SimulatorChoice& simulator : simulators) {
    if (simulator.foreign) {
      code[simulator.foreign->name] = simulator.foreign->code;
    }
  }
  return code;
}

/// Model variants of the reference. Throws InvalidInput if it has but one world, which they would share.
std::vector<pusht::SimulatorModel> variantsOfReference(const LoadedSimulator& reference, const RunOptions& options) {
  if (reference.hasOneWorld() && !variantsOf(options).empty()) {
    throw pusht::InvalidInput("model variants: must be left out: the reference " + reference.foreign->name +
                              " is a node, which has one world");
  }
  return loadVariants(reference.kind, reference.model.parameters, options);
}

/// Refuses more actions to be executed than an answer of the policy has, before a run begins.
void requireActions(const pusht::ChosenPolicy& policy, int execute) {
  if (execute == 0) {
    return;
  }
  try {
    policy.make()->begin({0, execute});
  } catch (pusht::Error& error) {
    error.addContext("policy " + policy.name);
    throw;
  }
}

}  // namespace

LoadedRun::LoadedRun(const pusht::PolicyChoice& policy, const SimulatorChoice& reference,
                     const std::vector<SimulatorChoice>& engines, const RunOptions& options)
    : LoadedRun(
          [&] { return pusht::choosePolicy(policy, pusht::installedFile("pusht_policy", pusht::kShippedCheckpoint)); },
          reference, engines, options) {}

LoadedRun::LoadedRun(const std::function<pusht::ChosenPolicy()>& choose_policy, const SimulatorChoice& reference,
                     const std::vector<SimulatorChoice>& engines, const RunOptions& options)
    : reference_(reference), variants_(variantsOfReference(reference_, options)), policy_(choose_policy()) {
  std::vector<SimulatorChoice> simulators = {reference};
  reference_code_ = codeOf(simulators, policy_);
  simulators.insert(simulators.end(), engines.begin(), engines.end());
  code_ = codeOf(simulators, policy_);
  requireActions(policy_, options.execute);
  warn(policy_.warning);
}

WorkerFactory LoadedRun::workerFactory(const LoadedSimulator& engine) const {
  const auto make_worlds = [make_reference = reference_.model.make_lanes, make_engine = engine.model.make_lanes,
                            one_engine = engine.hasOneWorld()](int lanes) {
    if (make_engine == nullptr) {
      return Worlds{make_reference(lanes), nullptr, nullptr};
    }
    return Worlds{make_reference(lanes), make_engine(lanes), one_engine ? nullptr : make_engine(lanes)};
  };
  const auto make_policy = [make = policy_.make, reference = reference_.loop, engine = engine.loop,
                            &task = reference_.task] { return pusht::looped(make(), reference, engine, task); };
  return {make_worlds, make_policy, [variants = variants_] { return worldsOf(variants); },
          reference_.hasOneWorld() || engine.hasOneWorld()};
}

nlohmann::ordered_json LoadedRun::provenance(const RunConfiguration& configuration,
                                             const LoadedSimulator& engine) const {
  nlohmann::ordered_json result =
      sim2sim::provenance(configuration, policy_.provenance, reference_.provenance(), engine.provenance());
  result["code"] = code_;
  return result;
}

nlohmann::json LoadedRun::identity() const {
  return {{"policy", policy_.identity}, {"reference", toJson(reference_.record())}};
}

nlohmann::json LoadedRun::referenceKey(const RunOptions& options) const {
  nlohmann::json key = referenceOptions(options);
  key["inputs"] = identity();
  key["code"] = reference_code_;
  return key;
}

}  // namespace sim2sim
