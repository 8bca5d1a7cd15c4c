// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/sweep_plan.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <optional>
#include <set>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/ros/parameters.hpp"

namespace sim2sim {
namespace {

constexpr std::size_t kMostRows = 100'000;
constexpr int kMostShards = 1'000'000;

/// "line 3, block_damp"
std::string placeOf(const YAML::Node& node, const std::string& key) {
  return "line " + std::to_string(node.Mark().line + 1) + ", " + key;
}

[[noreturn]] void refuse(const YAML::Node& node, const std::string& key, const std::string& rule) {
  throw pusht::InvalidInput(placeOf(node, key) + ": " + rule);
}

std::string textAt(const YAML::Node& node, const std::string& key) {
  if (!node.IsScalar()) {
    refuse(node, key, "must be a single value");
  }
  return node.Scalar();
}

template <class Integer>
Integer integerAt(const YAML::Node& node, const std::string& key) {
  const std::string text = textAt(node, key);
  const std::optional<Integer> value = pusht::decimal<Integer>(text);
  if (!value) {
    refuse(node, key, "'" + text + "' must be a decimal integer in range");
  }
  return *value;
}

const pusht::two_mass::Knob& knobAt(const YAML::Node& node) {
  const std::string name = textAt(node, "knob");
  const auto& knobs = pusht::two_mass::kKnobs;
  const auto knob = std::find_if(knobs.begin(), knobs.end(), [&](const auto& k) { return k.name == name; });
  if (knob == knobs.end()) {
    std::string names;
    for (const auto& known : knobs) {
      names += (names.empty() ? "" : ", ") + std::string(known.name);
    }
    refuse(node, name, "there is no such knob; there are " + names);
  }
  return *knob;
}

/// Calls check(); what it refuses is in the line of `node`.
template <class Check>
void inLineOf(const YAML::Node& node, Check check) {
  try {
    check();
  } catch (pusht::InvalidInput& error) {
    error.addContext("line " + std::to_string(node.Mark().line + 1));
    throw;
  }
}

void setKnob(pusht::TwoMassParameters& row, const pusht::two_mass::Knob& knob, const YAML::Node& value) {
  const double real = pusht::realFromText(placeOf(value, knob.name), textAt(value, knob.name));
  row.*knob.value = real + 0.0;  // -0.0 is 0.0
  inLineOf(value, [&] { knob.requireInRange(real); });
}

void requireRoom(const YAML::Node& node, const std::string& key, std::size_t rows) {
  if (rows > kMostRows) {
    refuse(node, key, "must give at most " + std::to_string(kMostRows) + " rows");
  }
}

/// Each key once; YAML itself would take the last.
void requireDistinctKeys(const YAML::Node& map) {
  std::set<std::string> seen;
  for (const auto& entry : map) {
    const std::string key = textAt(entry.first, "key");
    if (!seen.insert(key).second) {
      refuse(entry.first, key, "must be there once only");
    }
  }
}

std::vector<pusht::TwoMassParameters> rowsOfGrid(const YAML::Node& grid) {
  if (!grid.IsMap() || grid.size() == 0) {
    refuse(grid, "grid", "must map knobs to lists of values");
  }
  requireDistinctKeys(grid);
  std::vector<pusht::TwoMassParameters> rows(1);
  for (const auto& entry : grid) {
    const auto& knob = knobAt(entry.first);
    if (!entry.second.IsSequence() || entry.second.size() == 0) {
      refuse(entry.second, knob.name, "must be a list of values");
    }
    requireRoom(grid, "grid", rows.size() * entry.second.size());
    std::vector<pusht::TwoMassParameters> combined;
    for (const pusht::TwoMassParameters& row : rows) {
      for (const YAML::Node& value : entry.second) {
        combined.push_back(row);
        setKnob(combined.back(), knob, value);
      }
    }
    rows = std::move(combined);
  }
  for (const pusht::TwoMassParameters& row : rows) {
    inLineOf(grid, [&] { row.validate(); });
  }
  return rows;
}

std::vector<pusht::TwoMassParameters> rowsOfList(const YAML::Node& list) {
  if (!list.IsSequence() || list.size() == 0) {
    refuse(list, "rows", "must be a list of settings");
  }
  requireRoom(list, "rows", list.size());
  std::vector<pusht::TwoMassParameters> rows;
  for (const YAML::Node& setting : list) {
    if (!setting.IsMap()) {
      refuse(setting, "rows", "each must map knobs to values");
    }
    requireDistinctKeys(setting);
    rows.emplace_back();
    for (const auto& entry : setting) {
      setKnob(rows.back(), knobAt(entry.first), entry.second);
    }
    inLineOf(setting, [&] { rows.back().validate(); });
  }
  return rows;
}

std::vector<double> valuesOf(const pusht::TwoMassParameters& row) {
  std::vector<double> values(pusht::two_mass::kKnobs.size());
  std::transform(pusht::two_mass::kKnobs.begin(), pusht::two_mass::kKnobs.end(), values.begin(),
                 [&](const pusht::two_mass::Knob& knob) { return row.*knob.value; });
  return values;
}

void requireEachOnce(const std::vector<pusht::TwoMassParameters>& rows) {
  std::set<std::vector<double>> seen;
  for (const pusht::TwoMassParameters& row : rows) {
    if (!seen.insert(valuesOf(row)).second) {
      std::string setting;
      for (const auto& knob : pusht::two_mass::kKnobs) {
        setting += (setting.empty() ? "" : ", ") + std::string(knob.name) + " " + pusht::shortestText(row.*knob.value);
      }
      throw pusht::InvalidInput("rows: " + setting + " must be there once only");
    }
  }
}

SweepPlan planFrom(const YAML::Node& root) {
  if (!root.IsMap()) {
    throw pusht::InvalidInput("must map keys to values");
  }
  requireDistinctKeys(root);
  SweepPlan plan;
  for (const auto& entry : root) {
    const std::string key = entry.first.Scalar();
    const YAML::Node& value = entry.second;
    if (key == "policy") {
      plan.policy = textAt(value, key);
    } else if (key == "scene") {
      plan.scene = textAt(value, key);
    } else if (key == "seed") {
      plan.protocol.seed = integerAt<std::uint64_t>(value, key);
    } else if (key == "first_episode") {
      plan.protocol.first_episode = integerAt<int>(value, key);
    } else if (key == "episodes") {
      plan.protocol.episodes = integerAt<int>(value, key);
    } else if (key == "horizon") {
      plan.protocol.horizon = integerAt<int>(value, key);
    } else if (key == "grid") {
      plan.rows = rowsOfGrid(value);
    } else if (key == "rows") {
      plan.rows = rowsOfList(value);
    } else {
      refuse(entry.first, key,
             "there is no such key; there are policy, scene, seed, first_episode, episodes, horizon, grid, rows");
    }
  }
  if (root["grid"].IsDefined() == root["rows"].IsDefined()) {
    throw pusht::InvalidInput("must have either grid or rows");
  }
  requireEachOnce(plan.rows);
  plan.protocol.validate();
  return plan;
}

}  // namespace

SweepPlan readSweepPlan(const std::filesystem::path& path) {
  const std::string text = pusht::readFile(path, "sweep");
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(text);
    if (documents.size() > 1) {
      throw pusht::InvalidInput("must be one YAML document");
    }
    return planFrom(documents.empty() ? YAML::Node() : documents.front());
  } catch (const YAML::Exception& error) {
    throw pusht::InvalidInput("sweep " + path.string() + ": line " + std::to_string(error.mark.line + 1) +
                              ": must be YAML: " + error.msg);
  } catch (pusht::Error& error) {
    error.addContext("sweep " + path.string());
    throw;
  }
}

Shard Shard::from(const std::string& text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), end, shard.number);
  const bool slash = number.ec == std::errc() && number.ptr != end && *number.ptr == '/';
  const auto of = slash ? std::from_chars(number.ptr + 1, end, shard.of) : number;
  if (!slash || of.ec != std::errc() || of.ptr != end || shard.number < 1 || shard.number > shard.of ||
      shard.of > kMostShards) {
    throw pusht::InvalidInput("shard '" + text + "': must be I/N with I from 1 to N, e.g. 2/5");
  }
  return shard;
}

Protocol Shard::share(const Protocol& protocol) const {
  if (of > protocol.episodes) {
    throw pusht::InvalidInput("shard " + text() +
                              ": there must be at least as many episodes as shards, but there are " +
                              std::to_string(protocol.episodes));
  }
  const auto before = [&](int shards) {
    return static_cast<int>(static_cast<std::int64_t>(protocol.episodes) * shards / of);
  };
  Protocol share = protocol;
  share.first_episode = protocol.first_episode + before(number - 1);
  share.episodes = before(number) - before(number - 1);
  return share;
}

}  // namespace sim2sim
