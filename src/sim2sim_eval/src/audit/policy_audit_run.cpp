// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/policy_audit_run.hpp"

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "pusht_policy/checkpoint_home.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/json_text.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_serving/installed_file.hpp"

namespace sim2sim {
namespace {

using nlohmann::json;

/// Policy that is not asked once the process is interrupted.
class InterruptiblePolicy final : public pusht::Policy {
 public:
  explicit InterruptiblePolicy(pusht::Policy& policy) : policy_(policy) {}

  std::unique_ptr<Memory> begin(const pusht::Beginning& beginning) const override { return policy_.begin(beginning); }
  void act(pusht::Span<const Query> queries, pusht::Span<pusht::Action> actions) override {
    requireNotInterrupted();
    policy_.act(queries, actions);
  }

 private:
  pusht::Policy& policy_;
};

/// Loss of a training, if the checkpoint has a provenance that says it.
TrainingLoss lossOf(const std::filesystem::path& checkpoint) {
  const std::filesystem::path path = pusht::provenancePath(checkpoint);
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    return {};
  }
  const json provenance = pusht::parseJson(pusht::readFile(path, "provenance", pusht::kLargestSmallFile));
  const json training = provenance.value("training", json::object());
  const auto number_of = [&](const char* key) { return training.value(key, json()); };
  if (!number_of("final_train_loss").is_number() || !number_of("final_validation_loss").is_number()) {
    return {};
  }
  return {training.value("loss", std::string("loss")), number_of("final_train_loss"),
          number_of("final_validation_loss")};
}

std::string lossText(const TrainingLoss& loss) {
  constexpr int kDigits = 3;
  return loss.name.empty() ? ""
                           : "its training ended at " + pusht::significantText(loss.training, kDigits) + ", and at " +
                                 pusht::significantText(loss.validation, kDigits) + " on demonstrations left out (" +
                                 loss.name + ")\n";
}

}  // namespace

std::string PolicyAuditRun::text() const { return textOf(audit, policy, demonstrations) + lossText(loss); }

std::string PolicyAuditRun::json() const {
  nlohmann::ordered_json file = {{"format", kPolicyAuditFormat},
                                 {"policy", policy},
                                 {"sha256", sha256.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(sha256)},
                                 {"demonstrations", demonstrations}};
  file.update(toJson(audit));
  file["training"] = nullptr;
  if (!loss.name.empty()) {
    file["training"] = {
        {"loss", loss.name}, {"final_train_loss", loss.training}, {"final_validation_loss", loss.validation}};
  }
  constexpr int kIndent = 2;
  return file.dump(kIndent) + "\n";
}

PolicySignature signatureOf(const pusht::ChosenPolicy& policy) {
  PolicySignature signature;
  const json description = policy.provenance.value("description", json());
  if (description.is_object()) {
    signature.observations = description.at("observations").get<int>();
    signature.actions = description.at("actions").get<int>();
    signature.has_state = !description.value("state", json()).is_null();
    signature.is_stochastic = !description.value("noise", json()).is_null();
  }
  const bool is_planner = policy.name == pusht::kPlannerPolicy;
  signature.has_state = signature.has_state || is_planner || policy.name == pusht::kExpertPolicy;
  signature.is_stochastic = signature.is_stochastic || is_planner;
  return signature;
}

PolicyAudit auditNamedPolicy(pusht::Policy& policy, const std::string& name, const PolicySignature& signature,
                             const std::vector<Demonstration>& demonstrations) {
  InterruptiblePolicy interruptible(policy);
  try {
    return auditPolicy(interruptible, signature, demonstrations);
  } catch (const pusht::BadDependency& error) {
    throw pusht::BadDependency("policy " + name + ": " + error.what());
  } catch (const pusht::InvalidInput& error) {
    throw pusht::InvalidInput("demonstrations: " + std::string(error.what()));
  }
}

PolicyAuditRun auditPolicyFile(const std::string& policy, const std::vector<Demonstration>& demonstrations) {
  const std::filesystem::path shipped = pusht::installedFile("pusht_policy", pusht::kShippedCheckpoint);
  const pusht::ChosenPolicy chosen = pusht::choosePolicy({policy, true}, shipped, [] { return interrupted(); });
  PolicyAuditRun run;
  run.policy = policy;
  run.sha256 = chosen.provenance.value("sha256", "");
  run.loss = lossOf(policy == pusht::kShippedPolicy ? shipped : std::filesystem::path(policy));
  run.audit = auditNamedPolicy(*chosen.make(), policy, signatureOf(chosen), demonstrations);
  return run;
}

}  // namespace sim2sim
