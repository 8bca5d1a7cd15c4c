// SPDX-License-Identifier: BSD-3-Clause
#include "live/evaluator_parameters.hpp"

#include "live/world_memory.hpp"

namespace sim2sim {
namespace {

constexpr double kRateForEyes = 50.0;  // [control steps/s]
constexpr double kFullSpeed = 0.0;

// Words of an optional text that is left out.
constexpr const char* kAuto = "auto";
constexpr const char* kNone = "none";

void take(pusht::ParameterReader& parameters, const char* name, int& value) { value = parameters.integer(name, value); }
void take(pusht::ParameterReader& parameters, const char* name, std::uint64_t& value) {
  value = parameters.seed(name, value);
}
void take(pusht::ParameterReader& parameters, const char* name, double& value) { value = parameters.real(name, value); }
void take(pusht::ParameterReader& parameters, const char* name, bool& value) { value = parameters.flag(name, value); }
void take(pusht::ParameterReader& parameters, const char* name, std::vector<int>& value) {
  value = reanchorFrom(parameters.optionalText(name, kNone));
}
void take(pusht::ParameterReader& parameters, const char* name, std::vector<std::string>& value) {
  value = modelVariantsFrom(parameters.optionalText(name, kNone));
}
void take(pusht::ParameterReader& parameters, const char* name, std::string& value) {
  value = parameters.text(name, value);
}
// 0 stands for none.
void take(pusht::ParameterReader& parameters, const char* name, std::optional<double>& value) {
  const double given = parameters.real(name, value.value_or(0.0));
  value = given == 0.0 ? std::nullopt : std::optional(given);
}

}  // namespace

std::string EvaluatorParameters::outOf(pusht::ParameterReader& parameters) {
  return parameters.optionalText("out", kAuto);
}

std::string EvaluatorParameters::statusFileOf(pusht::ParameterReader& parameters) {
  return parameters.optionalText("status_file", kNone);
}

EvaluatorParameters EvaluatorParameters::load(pusht::ParameterReader& parameters) {
  EvaluatorParameters loaded;
  LiveRequest& request = loaded.request;
  request.services.worlds = {parameters.services("reference_namespace", "reference"),
                             parameters.services("engine_namespace", "engine"),
                             parameters.services("replay_namespace", "engine_replay")};
  request.services.policy = parameters.services("policy_namespace", "policy");
  request.policy = parameters.optionalText("policy", kAuto);
  forEachOption([&](const auto& option) { take(parameters, option.name, option.of(request.protocol)); });
  request.smoke = parameters.flag("smoke", request.smoke);
  if (request.smoke) {
    request.protocol = smokeRun(request.protocol);
  }
  request.protocol.validate();
  loaded.headless = parameters.text("headless", "rviz was not asked for");
  request.rate = loaded.headless.empty() ? kRateForEyes : kFullSpeed;
  take(parameters, "rate", request.rate);
  take(parameters, "record", request.record);
  take(parameters, "overwrite", request.overwrite);
  request.starts = parameters.optionalText("starts", kNone);
  request.out = outOf(parameters);
  const auto values = [&](const std::string& key) { return parametersFrom(key, parameters.optionalText(key, kNone)); };
  request.simulators = {{parameters.optionalText("reference", kAuto), values("reference_parameters")},
                        {parameters.optionalText("engine", kAuto), values("engine_parameters")}};
  loopOf(request.simulators.reference);  // refuses one that there is not, before nodes are waited for
  loopOf(request.simulators.engine);
  loaded.start = parameters.flag("start", loaded.start);
  loaded.exit = parameters.flag("exit", loaded.exit) && !loaded.headless.empty();
  loaded.respawn = parameters.flag("respawn", loaded.respawn);
  loaded.deadline = parameters.positive("deadline", loaded.deadline);
  loaded.patience = parameters.positive("patience", loaded.patience);
  loaded.grace = parameters.positive("grace", loaded.grace);
  loaded.status_file = statusFileOf(parameters);
  loaded.report = parameters.flag("report", loaded.report);
  return loaded;
}

}  // namespace sim2sim
