// SPDX-License-Identifier: BSD-3-Clause
#include "batch/sweep_description.hpp"

#include <cstddef>

#include "pusht_task/error.hpp"
#include "sim2sim_protocol/results/attribution_files.hpp"

namespace sim2sim {

using nlohmann::json;
using nlohmann::ordered_json;

json describeWithoutEngine(const Protocol& protocol, const LoadedRun& loaded) {
  RunConfiguration configuration;
  configuration.protocol = protocol;
  configuration.policy = loaded.policyName();
  configuration.reference = loaded.reference().record();
  json common = describe(configuration);
  for (const char* of_engine : {"engine_simulator", "knobs", "simulators", "config_hash"}) {
    common.erase(of_engine);
  }
  return common;
}

RunConfiguration rowConfiguration(const Protocol& protocol, const LoadedRun& loaded, const LoadedSimulator& engine) {
  RunConfiguration configuration;
  configuration.protocol = protocol;
  configuration.policy = loaded.policyName();
  configuration.reference = loaded.reference().record();
  configuration.engine = engine.record();
  return configuration;
}

json describe(const SweepPlan& plan, const std::vector<LoadedRun>& loaded,
              const std::vector<SimulatorRecord>& engines) {
  json description = describeWithoutEngine(plan.protocol, loaded.front());
  json& rows = description["rows"] = json::array();
  if (plan.lists_policies) {
    description.erase("policy");
    description.erase("reference_simulator");
    json& policies = description["policies"] = json::array();
    for (std::size_t i = 0; i < plan.policies.size(); ++i) {
      policies.push_back({{"policy", loaded[i].policyName()},
                          {"group", plan.policies[i].group},
                          {"reference", textOf(plan.policies[i].reference)},
                          {"inputs", loaded[i].identity()}});
    }
  } else {
    description["inputs"] = loaded.front().identity();
  }
  for (std::size_t row = 0; row < engines.size(); ++row) {
    const json engine = toJson(engines[row]);
    rows.push_back(
        plan.lists_policies
            ? json{{"policy", plan.rows[row].policy}, {"engine", engine}, {"name", textOf(plan.rows[row].engine)}}
            : engine);
  }
  if (plan.sample) {
    description["permutations"] = toJson(*plan.sample);
  }
  return description;
}

ordered_json provenanceOf(const SweepPlan& plan, const Protocol& protocol, const std::vector<LoadedRun>& loaded) {
  const LoadedSimulator engine(plan.rows.front().engine);
  std::vector<ordered_json> each;
  for (const LoadedRun& run : loaded) {
    each.push_back(run.provenance(rowConfiguration(protocol, run, engine), engine));
    for (const char* of_a_row : {"configuration", "engine"}) {
      each.back().erase(of_a_row);
    }
  }
  ordered_json provenance = each.front();
  if (plan.lists_policies) {
    ordered_json policies = ordered_json::array();
    ordered_json code = ordered_json::array();
    for (const ordered_json& one : each) {
      policies.push_back({{"policy", one.at("policy")}, {"reference", one.at("reference")}});
      code.push_back(one.at("code"));
    }
    for (const char* of_a_policy : {"policy", "reference"}) {
      provenance.erase(of_a_policy);
    }
    provenance["policies"] = policies;
    provenance["code"] = code;
  }
  provenance["format"] = describeWithoutEngine(plan.protocol, loaded.front()).at("format");
  return provenance;
}

std::vector<RunConfiguration> rowsOf(const json& description) {
  std::vector<RunConfiguration> rows;
  const bool lists_policies = description.contains("policies");
  for (const json& row : description.at("rows")) {
    const json& policy =
        lists_policies ? description.at("policies").at(row.at("policy").get<std::size_t>()) : description;
    RunConfiguration configuration;
    configuration.protocol = protocolFrom(description);
    configuration.policy = policy.at("policy");
    configuration.reference = simulatorFrom(policy.at("inputs").at("reference"));
    configuration.engine = simulatorFrom(lists_policies ? row.at("engine") : row);
    rows.push_back(std::move(configuration));
  }
  if (rows.empty()) {
    throw pusht::InvalidInput("there are no rows");
  }
  return rows;
}

}  // namespace sim2sim
