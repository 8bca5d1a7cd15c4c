// SPDX-License-Identifier: BSD-3-Clause
#include "batch/hypotheses_file.hpp"

#include <yaml-cpp/yaml.h>

#include <string>

#include "plan_values.hpp"
#include "pusht_task/error.hpp"

namespace sim2sim {
namespace {

bool truthAt(const YAML::Node& node, const std::string& key) {
  const std::string text = textAt(node, key);
  if (text != "true" && text != "false") {
    refuse(node, key, "'" + text + "' must be true or false");
  }
  return text == "true";
}

Hypothesis::Side signAt(const YAML::Node& node, const std::string& key) {
  const std::string text = textAt(node, key);
  if (text != "above" && text != "below") {
    refuse(node, key, "'" + text + "' must be above or below");
  }
  return text == "above" ? Hypothesis::Side::kAbove : Hypothesis::Side::kBelow;
}

double marginAt(const YAML::Node& node, const std::string& key) {
  const std::optional<double> margin = pusht::decimal<double>(textAt(node, key));
  if (!margin || *margin <= 0.0) {
    refuse(node, key, "'" + textAt(node, key) + "' must be a decimal number above 0");
  }
  return *margin;
}

/// Takes a key of a difference; false if it has no such key.
bool take(GroupDifference& difference, const std::string& key, const YAML::Node& value) {
  if (key == "more") {
    difference.more = textAt(value, key);
  } else if (key == "less") {
    difference.less = textAt(value, key);
  } else if (key == "in") {
    difference.simulator = textAt(value, key);
  } else if (key == "figure") {
    difference.figure = textAt(value, key);
  } else if (key == "paired") {
    difference.paired = truthAt(value, key);
  } else {
    return false;
  }
  return true;
}

/// Takes a key of a ranking; false if it has no such key.
bool take(GroupRanking& ranking, const std::string& key, const YAML::Node& value) {
  if (key == "ranking") {
    if (!value.IsSequence() || value.size() == 0) {
      refuse(value, key, "must list groups");
    }
    for (const YAML::Node& group : value) {
      ranking.groups.push_back(textAt(group, key));
    }
  } else if (key == "here") {
    ranking.here = textAt(value, key);
  } else if (key == "there") {
    ranking.there = textAt(value, key);
  } else {
    return false;
  }
  return true;
}

void requireWhole(const GroupDifference& difference, const std::string& name, const YAML::Node& map) {
  if (difference.more.empty() || difference.less.empty() || difference.simulator.empty()) {
    refuse(map, name, "must have more, less and in");
  }
}

void requireWhole(const GroupRanking& ranking, const std::string& name, const YAML::Node& map) {
  if (ranking.here.empty() || ranking.there.empty()) {
    refuse(map, name, "must have ranking, here and there");
  }
}

/// Reads the figure, and the side on which it is expected.
template <class Figure>
Hypothesis hypothesisOn(Figure figure, const std::string& name, const YAML::Node& map, const std::string& keys) {
  Hypothesis hypothesis;
  hypothesis.name = name;
  for (const auto& entry : map) {
    const std::string key = textAt(entry.first, "key");
    if (key == "side") {
      hypothesis.side = signAt(entry.second, key);
    } else if (key == "within") {
      hypothesis.side = Hypothesis::Side::kWithin;
      hypothesis.margin = marginAt(entry.second, key);
    } else if (!take(figure, key, entry.second)) {
      refuse(entry.first, key, "there is no such key; there are " + keys + ", side, within");
    }
  }
  requireWhole(figure, name, map);
  if (map["side"].IsDefined() == map["within"].IsDefined()) {
    refuse(map, name, "must have either side or within");
  }
  hypothesis.figure = figure;
  return hypothesis;
}

Hypothesis hypothesisIn(const YAML::Node& key, const YAML::Node& map) {
  const std::string name = textAt(key, "hypothesis");
  if (!map.IsMap()) {
    refuse(map, name, "must map more, less and in, or ranking, here and there, and a side to values");
  }
  requireDistinctKeys(map);
  if (map["ranking"].IsDefined()) {
    return hypothesisOn(GroupRanking(), name, map, "ranking, here, there");
  }
  return hypothesisOn(GroupDifference(), name, map, "more, less, in, figure, paired");
}

}  // namespace

std::vector<Hypothesis> readHypotheses(const std::filesystem::path& path) {
  return fromYaml(path, "hypotheses", [](const YAML::Node& root) {
    if (!root.IsMap() || root.size() == 0) {
      throw pusht::InvalidInput("must map names to hypotheses");
    }
    requireDistinctKeys(root);
    std::vector<Hypothesis> hypotheses;
    for (const auto& entry : root) {
      hypotheses.push_back(hypothesisIn(entry.first, entry.second));
    }
    return hypotheses;
  });
}

}  // namespace sim2sim
