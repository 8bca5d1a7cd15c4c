// SPDX-License-Identifier: BSD-3-Clause
#include "batch/sweep_plan.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include "plan_loops.hpp"
#include "plan_policies.hpp"
#include "plan_values.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_eval/batch/batch_options.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

namespace sim2sim {
namespace {

constexpr std::size_t kMostRows = 100'000;

void setParameter(SimulatorChoice& row, const YAML::Node& key, const YAML::Node& value) {
  const std::string name = textAt(key, "parameter");
  inLineOf(key, [&] { row.at(name); });
  inLineOf(value, [&] { row.set(name, textAt(value, name)); });
}

/// Throws InvalidInput in the line of `node` if the kind refuses the setting.
void requireLoads(const YAML::Node& node, const SimulatorChoice& row) {
  inLineOf(node, [&] { row.kind.get().load(row.parameters, row.kind.get().ownTask()); });
}

void requireRowLimit(const YAML::Node& node, const std::string& key, std::size_t rows) {
  if (rows > kMostRows) {
    refuse(node, key, "must give at most " + std::to_string(kMostRows) + " rows");
  }
}

std::vector<SimulatorChoice> rowsOfGrid(const SimulatorChoice& engine, const YAML::Node& grid) {
  if (!grid.IsMap() || grid.size() == 0) {
    refuse(grid, "grid", "must map parameters to lists of values");
  }
  requireDistinctKeys(grid);
  std::vector<SimulatorChoice> rows = {engine};
  for (const auto& entry : grid) {
    if (!entry.second.IsSequence() || entry.second.size() == 0) {
      refuse(entry.second, textAt(entry.first, "parameter"), "must be a list of values");
    }
    requireRowLimit(grid, "grid", rows.size() * entry.second.size());
    std::vector<SimulatorChoice> combined;
    for (const SimulatorChoice& row : rows) {
      for (const YAML::Node& value : entry.second) {
        combined.push_back(row);
        setParameter(combined.back(), entry.first, value);
      }
    }
    rows = std::move(combined);
  }
  for (const SimulatorChoice& row : rows) {
    requireLoads(grid, row);
  }
  return rows;
}

std::vector<SimulatorChoice> rowsOfList(const SimulatorChoice& engine, const YAML::Node& list) {
  if (!list.IsSequence() || list.size() == 0) {
    refuse(list, "rows", "must be a list of settings");
  }
  requireRowLimit(list, "rows", list.size());
  std::vector<SimulatorChoice> rows;
  for (const YAML::Node& parameters : list) {
    if (!parameters.IsMap()) {
      refuse(parameters, "rows", "each must map parameters to values");
    }
    requireDistinctKeys(parameters);
    rows.push_back(engine);
    for (const auto& entry : parameters) {
      setParameter(rows.back(), entry.first, entry.second);
    }
    requireLoads(parameters, rows.back());
  }
  return rows;
}

OrderSample sampleIn(const YAML::Node& node) {
  if (!node.IsMap()) {
    refuse(node, "permutations", "must map switches, orders and, if need be, seed");
  }
  requireDistinctKeys(node);
  OrderSample sample;
  for (const auto& entry : node) {
    const std::string key = textAt(entry.first, "key");
    if (key == "switches") {
      if (!entry.second.IsSequence() || entry.second.size() < 2) {
        refuse(entry.second, key, "must be a list of two parameters or more");
      }
      for (const YAML::Node& name : entry.second) {
        sample.players.push_back(textAt(name, key));
      }
    } else if (key == "orders") {
      sample.orders = integerAt<int>(entry.second, key);
    } else if (key == "seed") {
      sample.seed = integerAt<std::uint32_t>(entry.second, key);
    } else {
      refuse(entry.first, key, "there is no such key; there are switches, orders, seed");
    }
  }
  constexpr int kMostOrders = 10'000;
  if (sample.players.empty() || sample.orders < 1 || sample.orders > kMostOrders) {
    refuse(node, "permutations", "must have switches and orders, from 1 to " + std::to_string(kMostOrders));
  }
  return sample;
}

/// A row for each combination along the orders, switches set by name.
std::vector<SimulatorChoice> rowsOfSample(const SimulatorChoice& engine, const YAML::Node& node,
                                          const OrderSample& sample) {
  std::vector<Coalition> combinations;
  inLineOf(node, [&] { combinations = coalitionsAlong(sample.draw()); });
  requireRowLimit(node, "permutations", combinations.size());
  std::vector<SimulatorChoice> rows;
  for (const Coalition on : combinations) {
    rows.push_back(engine);
    for (std::size_t i = 0; i < sample.players.size(); ++i) {
      inLineOf(node, [&] { rows.back().set(sample.players[i], (on >> i & 1U) != 0 ? "true" : "false"); });
    }
  }
  requireLoads(node, rows.front());
  return rows;
}

void requireEachOnce(const std::vector<SimulatorChoice>& rows) {
  for (auto row = rows.begin(); row != rows.end(); ++row) {
    if (std::find(rows.begin(), row, *row) != row) {
      throw pusht::InvalidInput("rows: " + textOf(*row) + " must appear only once");
    }
  }
}

/// The parameters of the reference that are keys of a plan too: those of the course's.
std::vector<std::string> shortForms() {
  std::vector<std::string> names;
  if (const auto* const reference = pusht::SimulatorKinds::installed().find(kCourseReference); reference != nullptr) {
    for (const pusht::ParameterDescriptor& parameter : reference->parameters) {
      names.push_back(parameter.name);
    }
  }
  return names;
}

/// Reference of all policies; none: each has its home. Throws InvalidInput if a key gives parameters to homes.
std::optional<SimulatorChoice> referenceIn(const YAML::Node& root) {
  const YAML::Node simulator = root["reference"];
  if (simulator.IsDefined() && textAt(simulator, "reference") == kHome) {
    std::vector<std::string> keys = shortForms();
    keys.emplace_back("reference_parameters");
    for (const std::string& key : keys) {
      if (const YAML::Node node = root[key]; node.IsDefined()) {
        refuse(node, key, "must not be there if the reference is each policy's home");
      }
    }
    return std::nullopt;
  }
  SimulatorChoice reference =
      simulator.IsDefined() ? simulatorAt(simulator, "reference") : chooseSimulator(kCourseReference, {});
  if (const YAML::Node parameters = root["reference_parameters"]; parameters.IsDefined()) {
    if (!parameters.IsMap()) {
      refuse(parameters, "reference_parameters", "must map parameters to values");
    }
    requireDistinctKeys(parameters);
    for (const auto& entry : parameters) {
      setParameter(reference, entry.first, entry.second);
    }
  }
  for (const std::string& name : shortForms()) {
    const YAML::Node value = root[name];
    const YAML::Node parameters = root["reference_parameters"];
    if (value.IsDefined() && parameters.IsDefined() && parameters[name].IsDefined()) {
      refuse(value, name, "must appear only once; it is under reference_parameters too");
    }
    if (value.IsDefined()) {
      inLineOf(value, [&] { reference.parameters.set(name, textAt(value, name)); });
    }
  }
  return reference;
}

/// Engines in the order of the plan.
std::vector<SimulatorChoice> enginesIn(const YAML::Node& root) {
  const YAML::Node node = root["engine"];
  if (!node.IsDefined()) {
    return {chooseSimulator(kCourseEngine, {})};
  }
  if (!node.IsSequence()) {
    return {simulatorAt(node, "engine")};
  }
  if (node.size() == 0) {
    refuse(node, "engine", "must be a simulator, or a list of simulators");
  }
  std::vector<SimulatorChoice> engines;
  for (const YAML::Node& engine : node) {
    engines.push_back(simulatorAt(engine, "engine"));
  }
  return engines;
}

/// Engines of the rows, each with its parameters.
std::vector<SimulatorChoice> rowsIn(const YAML::Node& root, const std::optional<OrderSample>& sample) {
  const YAML::Node grid = root["grid"];
  const YAML::Node list = root["rows"];
  const YAML::Node permutations = root["permutations"];
  const std::vector<SimulatorChoice> engines = enginesIn(root);
  const int ways = (grid.IsDefined() ? 1 : 0) + (list.IsDefined() ? 1 : 0) + (permutations.IsDefined() ? 1 : 0);
  if (ways > 1) {
    throw pusht::InvalidInput("must have either grid, rows or permutations");
  }
  if (ways == 0 && engines.size() == 1 && !root["policies"].IsDefined() &&
      !(root["loop"].IsDefined() && root["loop"].IsSequence())) {
    throw pusht::InvalidInput("must have grid, rows, permutations, or a list of engines, policies or loops");
  }
  if (sample && engines.size() > 1) {
    throw pusht::InvalidInput("permutations: must be of one engine");
  }
  std::vector<SimulatorChoice> rows;
  for (const SimulatorChoice& engine : engines) {
    const std::vector<SimulatorChoice> of_engine = sample             ? rowsOfSample(engine, permutations, *sample)
                                                   : grid.IsDefined() ? rowsOfGrid(engine, grid)
                                                   : list.IsDefined() ? rowsOfList(engine, list)
                                                                      : std::vector<SimulatorChoice>{engine};
    rows.insert(rows.end(), of_engine.begin(), of_engine.end());
  }
  requireRowLimit(root, "rows", rows.size());
  requireEachOnce(rows);
  return rows;
}

template <class Integer>
void take(const YAML::Node& node, const std::string& key, Integer& value) {
  value = integerAt<Integer>(node, key);
}

void take(const YAML::Node& node, const std::string& key, double& value) {
  const std::optional<double> number = pusht::decimal<double>(textAt(node, key));
  if (!number) {
    refuse(node, key, "'" + node.Scalar() + "' must be a decimal number");
  }
  value = *number;
}

void take(const YAML::Node& node, const std::string& key, std::optional<double>& value) {
  take(node, key, value.emplace());
}

void take(const YAML::Node& node, const std::string& key, bool& value) {
  const std::string text = textAt(node, key);
  if (text != "true" && text != "false") {
    refuse(node, key, "'" + text + "' must be true or false");
  }
  value = text == "true";
}

void take(const YAML::Node& node, const std::string& key, std::string& value) { value = textAt(node, key); }

void take(const YAML::Node& node, const std::string& key, std::vector<int>& value) {
  if (!node.IsSequence()) {
    refuse(node, key, "must be a list of control steps");
  }
  for (const YAML::Node& every : node) {
    value.push_back(integerAt<int>(every, key));
  }
  RunOptions asked;
  asked.reanchor = value;
  inLineOf(node, [&] { probesOf(asked); });
}

void take(const YAML::Node& node, const std::string& key, std::vector<std::string>& value) {
  if (!node.IsSequence()) {
    refuse(node, key, "must be a list of model variants");
  }
  std::vector<std::string> variants;
  for (const YAML::Node& variant : node) {
    variants.push_back(textAt(variant, key));
  }
  inLineOf(node, [&] { value = modelVariantsFrom(pusht::joined(variants, ",")); });
}

/// The options that the plan names, and a number of episodes that fits the file of initial states.
Protocol protocolIn(const YAML::Node& root, const std::filesystem::path& starts) {
  Protocol protocol;
  forEachOption([&](const auto& option) {
    if (const YAML::Node node = root[option.name]; option.in_plan && node.IsDefined()) {
      take(node, option.name, option.of(protocol));
    }
  });
  protocol.episodes = root["episodes"].IsDefined() ? protocol.episodes : defaultEpisodes(protocol, starts);
  protocol.carryTask();
  protocol.validate();
  return protocol;
}

/// Adds rows of the policies from `first` on. Listed policies have none in their references: a matrix has their success
/// there already.
void addRows(SweepPlan& plan, std::size_t first, const std::vector<SimulatorChoice>& engines, bool listed) {
  for (std::size_t policy = first; policy < plan.policies.size(); ++policy) {
    const std::size_t before = plan.rows.size();
    for (const SimulatorChoice& engine : engines) {
      if (!listed || !(engine == plan.policies[policy].reference)) {
        requireTwoWorlds(plan.policies[policy].reference, engine);
        plan.rows.push_back({policy, engine});
      }
    }
    if (plan.rows.size() == before && plan.policies.size() > 1) {
      throw pusht::InvalidInput("policy " + plan.policies[policy].policy +
                                ": must have an engine beside its reference, has none");
    }
  }
}

/// Adds each policy in each loop, which is the same in its reference and in its engines.
void addPoliciesInLoops(SweepPlan& plan, const YAML::Node& root, const std::vector<PlannedPolicy>& policies,
                        const std::vector<SimulatorChoice>& engines) {
  const std::vector<PlannedLoop> loops = loopsIn(root);
  const bool listed = root["policies"].IsDefined();
  plan.lists_policies = listed || loops.size() > 1;
  for (const PlannedLoop& loop : loops) {
    const auto put = [&](const SimulatorChoice& simulator) { return inLoop(simulator, loop, loops); };
    const std::size_t first = plan.policies.size();
    for (PlannedPolicy policy : policies) {
      policy.reference = put(policy.reference);
      plan.policies.push_back(std::move(policy));
    }
    const SimulatorChoice& here = plan.policies[first].reference;
    for (std::size_t before = 0; before < first; before += policies.size()) {
      if (plan.policies[before].reference == here) {
        refuse(loop.node, "loop", "must appear only once; another one of the list is the same");
      }
    }
    std::vector<SimulatorChoice> in_loop;
    std::transform(engines.begin(), engines.end(), std::back_inserter(in_loop), put);
    addRows(plan, first, in_loop, listed);
  }
  if (plan.rows.empty() || plan.rows.size() > kMostRows) {
    throw pusht::InvalidInput("must give from 1 to " + std::to_string(kMostRows) + " rows, gives " +
                              std::to_string(plan.rows.size()));
  }
}

SweepPlan planFrom(const YAML::Node& root) {
  if (!root.IsMap()) {
    throw pusht::InvalidInput("must map keys to values");
  }
  requireDistinctKeys(root);
  std::vector<std::string> keys = {"policy", "policies", "reference", "reference_parameters",
                                   "loop",   "engine",   "starts",    "require"};
  forEachOption([&](const auto& option) {
    if (option.in_plan) {
      keys.emplace_back(option.name);
    }
  });
  keys.insert(keys.end(), {"grid", "rows", "permutations"});
  for (std::string& name : shortForms()) {
    keys.push_back(std::move(name));
  }
  for (const auto& entry : root) {
    if (std::find(keys.begin(), keys.end(), entry.first.Scalar()) == keys.end()) {
      refuse(entry.first, entry.first.Scalar(), "there is no such key; there are " + pusht::joined(keys));
    }
  }
  std::optional<OrderSample> sample;
  if (const YAML::Node permutations = root["permutations"]; permutations.IsDefined()) {
    sample = sampleIn(permutations);
  }
  SweepPlan plan;
  addPoliciesInLoops(plan, root, plannedPolicies(root, referenceIn(root)), rowsIn(root, sample));
  plan.sample = sample;
  if (const YAML::Node starts = root["starts"]; starts.IsDefined()) {
    plan.starts = textAt(starts, "starts");
  }
  plan.protocol = protocolIn(root, plan.starts);
  const auto put = [&](SimulatorChoice& simulator) { setTask(plan.protocol.runTask(), {simulator}); };
  inLineOf(root["task"].IsDefined() ? root["task"] : root, [&] {
    std::for_each(plan.policies.begin(), plan.policies.end(), [&](PlannedPolicy& each) { put(each.reference); });
    std::for_each(plan.rows.begin(), plan.rows.end(), [&](PlannedRow& each) { put(each.engine); });
  });
  plan.required = textsAt(root["require"], "require");
  return plan;
}

}  // namespace

SweepPlan readSweepPlan(const std::filesystem::path& path) { return fromYaml(path, "sweep", planFrom); }

}  // namespace sim2sim
