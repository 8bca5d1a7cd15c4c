// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/attribution_files.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {

using nlohmann::json;

namespace {

json readableAll(const std::vector<double>& values) {
  json result = json::array();
  std::transform(values.begin(), values.end(), std::back_inserter(result), readable);
  return result;
}

json gapJson(const AttributedGap& gap, const std::vector<std::string>& switches) {
  json by_switch = json::object();
  for (std::size_t i = 0; i < switches.size(); ++i) {
    const Share& share = gap.shares[i];
    json& keys = by_switch[switches[i]];
    addFigure(keys, "share", "", share.value, share.interval);
    addFigure(keys, "part", "", share.part, share.part_interval);
    if (!gap.gaps.empty()) {
      keys["alone"] = figureJson(gap.alone[i]);
      keys["leave_one_out"] = figureJson(gap.leave_one_out[i]);
    }
  }
  json pairs = json::array();
  for (const Interaction& interaction : gap.interactions) {
    json pair = figureJson(interaction.value);
    pair["switches"] = {switches[static_cast<std::size_t>(interaction.first)],
                        switches[static_cast<std::size_t>(interaction.second)]};
    pairs.push_back(pair);
  }
  json order = json::array();
  for (const int player : gap.best_order) {
    order.push_back(switches[static_cast<std::size_t>(player)]);
  }
  json steps = json::array();
  std::transform(gap.steps.begin(), gap.steps.end(), std::back_inserter(steps), figureJson<Difference>);
  return {{"title", gap.title},
          {"unit", gap.unit},
          {"all_off", readable(gap.all_off)},
          {"all_on", readable(gap.all_on)},
          {"gaps", readableAll(gap.gaps)},
          {"switches", by_switch},
          {"interactions", pairs},
          {"best_order", order},
          {"staircase", readableAll(gap.staircase)},
          {"staircase_steps", steps},
          {"null_model", figureJson(gap.null_model)},
          {"baseline", figureJson(gap.baseline)},
          {"floor", figureJson(gap.floor)}};
}

constexpr std::size_t kNameWidth = 18;
constexpr std::size_t kCellWidth = 42;

/// "+0.0198 m [0.0149, 0.0247]  25 %"
std::string shareCell(const Share& share, int digits) {
  const std::string part = std::isfinite(share.part) ? "  " + percent(share.part) : "";
  return signedText(share.value, share.interval, "", digits) + part;
}

/// Gaps that are wider with all switches off than those of a tee that never moves; empty if none is.
std::string beyondNullModel(const Attribution& attribution) {
  std::vector<std::string> titles;
  for (const AttributedGap& gap : attribution.gaps) {
    if (gap.all_off > gap.null_model.value) {
      titles.push_back(gap.title);
    }
  }
  return titles.empty() ? ""
                        : "(all off is farther from " + attribution.reference +
                              " than a tee that never moves: " + pusht::joined(titles, "; ") +
                              "; shares of such a gap say little of a good engine)\n";
}

/// Where the cost of a switch to the full engine is: the share is a mean over orders, most of them of poor engines.
std::string costsText(const Attribution& attribution) {
  return attribution.orders > 0 ? ""
                                : "(what a switch costs the engine that has all others: leave_one_out in " +
                                      std::string(kAttributionFile) +
                                      ", plot_sweep --costs; clearest where the plan has `reanchor: [5]`)\n";
}

}  // namespace

json toJson(const OrderSample& sample) {
  return {{"switches", sample.players}, {"orders", sample.orders}, {"seed", sample.seed}};
}

OrderSample orderSampleFrom(const json& json) {
  try {
    return {json.at("switches").get<std::vector<std::string>>(), json.at("orders").get<int>(),
            json.at("seed").get<std::uint32_t>()};
  } catch (const nlohmann::json::exception& error) {
    throw pusht::InvalidInput(std::string("permutations: must have switches, orders and seed: ") + error.what());
  }
}

json toJson(const Attribution& attribution) {
  json gaps = json::object();
  for (const AttributedGap& gap : attribution.gaps) {
    gaps[gap.name] = gapJson(gap, attribution.switches);
  }
  json names = json::array();
  for (const AttributedGap& gap : attribution.gaps) {
    names.push_back(gap.name);
  }
  return {{"format", kAttributionFormat},
          {"confidence", kConfidence},
          {"reference", attribution.reference},
          {"engine", attribution.engine},
          {"policy", attribution.policy},
          {"episodes", attribution.episodes},
          {"combinations", attribution.combinations},
          {"orders", attribution.orders},
          {"baseline", attribution.baseline},
          {"switches", attribution.switches},
          {"order", names},
          {"gaps", gaps}};
}

std::string toCsv(const Attribution& attribution) {
  std::ostringstream csv;
  csv << "gap,unit,switch,share,share_low,share_high,part,part_low,part_high,alone,leave_one_out\n";
  for (const AttributedGap& gap : attribution.gaps) {
    for (std::size_t i = 0; i < attribution.switches.size(); ++i) {
      const Share& share = gap.shares[i];
      csv << gap.name << ',' << gap.unit << ',' << attribution.switches[i] << ','
          << csvFigure(share.value, share.interval) << ',' << csvFigure(share.part, share.part_interval) << ','
          << (gap.gaps.empty() ? "," : csvNumber(gap.alone[i].value) + "," + csvNumber(gap.leave_one_out[i].value))
          << '\n';
    }
  }
  return csv.str();
}

std::string table(const Attribution& attribution) {
  constexpr int kDigits = 4;
  std::string text = attribution.engine + " against " + attribution.reference + ", policy " + attribution.policy +
                     ", " + std::to_string(attribution.episodes) + " episodes, " +
                     std::to_string(attribution.combinations) + " combinations" +
                     (attribution.orders > 0 ? " along " + std::to_string(attribution.orders) + " random orders" : "") +
                     "\n";
  // Position and angle of the same rollouts stand side by side.
  for (std::size_t first = 0; first < attribution.gaps.size(); first += 2) {
    const auto begin = attribution.gaps.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end =
        attribution.gaps.begin() + static_cast<std::ptrdiff_t>(std::min(first + 2, attribution.gaps.size()));
    const auto line = [&](const std::string& name, const auto& cell) {
      text += "  " + padded(name, kNameWidth);
      for (auto gap = begin; gap != end; ++gap) {
        text += padded(cell(*gap), kCellWidth);
      }
      text.erase(text.find_last_not_of(' ') + 1);
      text += '\n';
    };
    const auto plain = [](double value) { return pusht::fixedText(readable(value), kDigits); };
    line("", [](const AttributedGap& gap) { return gap.title + (gap.unit.empty() ? "" : " [" + gap.unit + "]"); });
    if (std::isfinite(begin->null_model.value)) {
      line("tee never moves", [&](const AttributedGap& gap) { return plain(gap.null_model.value); });
    }
    if (!attribution.baseline.empty()) {
      line("baseline", [&](const AttributedGap& gap) { return plain(gap.baseline.value); });
    }
    line("all off", [&](const AttributedGap& gap) { return plain(gap.all_off); });
    for (std::size_t i = 0; i < attribution.switches.size(); ++i) {
      line(attribution.switches[i], [&](const AttributedGap& gap) { return shareCell(gap.shares[i], kDigits); });
    }
    line("all on", [&](const AttributedGap& gap) { return plain(gap.all_on); });
  }
  if (!attribution.baseline.empty()) {
    text += "(baseline: " + attribution.baseline + ")\n";
  }
  return text + "(each line: how much of the gap the switch closes, averaged over all orders of switching on, with " +
         pusht::fixedText(100.0 * kConfidence, 0) +
         " % interval and share of the whole;\nsuccess: reference rate minus engine rate." +
         (attribution.episodes < kFewestPairs ? " Below " + std::to_string(kFewestPairs) + " episodes no intervals"
                                              : "") +
         ")\n" + beyondNullModel(attribution) + costsText(attribution);
}

}  // namespace sim2sim
