// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/agreement_files.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {

using nlohmann::json;

namespace {

constexpr std::array kComponentNames = {"position", "angle"};

const Quantity& quantityOf(std::size_t component) {
  return kQuantities[quantityIndex(kDivergencePairs.at(component).divergence)];
}

json distancesJson(const std::vector<Estimate>& distances) {
  json list = json::array();
  std::transform(distances.begin(), distances.end(), std::back_inserter(list), figureJson<Estimate>);
  return list;
}

json rowsJson(const std::vector<std::vector<Estimate>>& rows) {
  json list = json::array();
  std::transform(rows.begin(), rows.end(), std::back_inserter(list), distancesJson);
  return list;
}

json sharesJson(const AgreementFigures& figures, double Centrality::*share) {
  if (!figures.centrality) {
    return {};
  }
  json shares = json::array();
  for (const Centrality& centrality : *figures.centrality) {
    shares.push_back(readable(centrality.*share));
  }
  return shares;
}

json simulatorJson(const SimulatorRecord& record) { return json(toJson(record)); }

/// "0.951 [0.803, 1.13]", in thousandths of the unit.
std::string distanceText(const Estimate& distance) {
  constexpr double kThousand = 1000.0;
  constexpr int kDigits = 3;
  constexpr double kLarge = 1000.0;  // beyond it so few digits would need an exponent
  const auto text = [](double value) {
    const double shown = readable(value) * kThousand;
    return shown < kLarge ? pusht::significantText(shown, kDigits) : pusht::fixedText(shown, 0);
  };
  return text(distance.value) +
         (distance.interval ? " [" + text(distance.interval->low) + ", " + text(distance.interval->high) + "]" : "");
}

std::string farthestText(const std::vector<Estimate>& variants) {
  const auto farthest = std::max_element(variants.begin(), variants.end(),
                                         [](const Estimate& a, const Estimate& b) { return a.value < b.value; });
  return farthest == variants.end() ? "-" : distanceText(*farthest);
}

/// "position [mm], reset to the reference's state every 5 control steps"
std::string headingOf(const AgreementReplay& replay, std::size_t component) {
  const std::string how =
      replay.reset_every == 0
          ? "in open loop"
          : "reset to the reference's state every " +
                (replay.reset_every == 1 ? "control step" : std::to_string(replay.reset_every) + " control steps");
  return std::string(kComponentNames.at(component)) + " [m" + quantityOf(component).unit + "], " + how;
}

std::string matrixOf(const Agreement& agreement, const AgreementFigures& figures) {
  std::vector<std::vector<std::string>> rows(1, {""});
  const auto add = [&](const std::string& name, const std::function<std::string(std::size_t)>& cell) {
    rows.push_back({name});
    for (std::size_t i = 0; i < agreement.simulators.size(); ++i) {
      rows.back().push_back(cell(i));
    }
  };
  for (std::size_t i = 0; i < agreement.simulators.size(); ++i) {
    rows.front().push_back(agreement.simulators[i].name);
    add(agreement.simulators[i].name, [&](std::size_t j) { return distanceText(figures.distances[i][j]); });
  }
  add("to all others", [&](std::size_t i) { return distanceText(figures.others[i]); });
  add("to own variant", [&](std::size_t i) { return farthestText(figures.variants[i]); });
  if (figures.centrality) {
    add("most central", [&](std::size_t i) { return percent((*figures.centrality)[i].most); });
    add("at the edge", [&](std::size_t i) { return percent((*figures.centrality)[i].least); });
  }
  return aligned(rows);
}

}  // namespace

json toJson(const Agreement& agreement) {
  json simulators = json::array();
  for (const AgreementSimulator& simulator : agreement.simulators) {
    simulators.push_back({{"name", simulator.name},
                          {"variants", simulator.variants},
                          {"title", titleOf(simulator.record)},
                          {"simulator", simulatorJson(simulator.record)}});
  }
  json replays = json::array();
  for (const AgreementReplay& replay : agreement.replays) {
    json content = {{"reset_every", replay.reset_every == 0 ? json() : json(replay.reset_every)}};
    for (std::size_t component = 0; component < kComponentNames.size(); ++component) {
      const AgreementFigures& figures = replay.figures.at(component);
      content[kComponentNames.at(component)] = {{"unit", quantityOf(component).unit},
                                                {"distances", rowsJson(figures.distances)},
                                                {"others", distancesJson(figures.others)},
                                                {"variants", rowsJson(figures.variants)},
                                                {"most_central", sharesJson(figures, &Centrality::most)},
                                                {"least_central", sharesJson(figures, &Centrality::least)}};
    }
    replays.push_back(content);
  }
  return {
      {"format", kAgreementFormat}, {"confidence", kConfidence},
      {"run", agreement.run},       {"reference", agreement.reference ? simulatorJson(*agreement.reference) : json()},
      {"simulators", simulators},   {"replays", replays}};
}

std::string table(const Agreement& agreement) {
  std::ostringstream text;
  text << "policy " << agreement.run.at("policy").get<std::string>() << ", " << agreement.run.at("episodes")
       << " episodes; all replay the actions of "
       << (agreement.reference ? titleOf(*agreement.reference) : "each row's simulator") << ": mean divergence\n";
  for (const AgreementReplay& replay : agreement.replays) {
    for (std::size_t component = 0; component < kComponentNames.size(); ++component) {
      text << '\n' << headingOf(replay, component) << '\n' << matrixOf(agreement, replay.figures.at(component));
    }
  }
  return text.str();
}

}  // namespace sim2sim
