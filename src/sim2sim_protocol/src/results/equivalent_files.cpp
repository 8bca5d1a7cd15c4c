// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/equivalent_files.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "pusht_task/constants.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/table.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {

using nlohmann::json;

namespace {

constexpr const char* kSteps = "control steps";
constexpr double kMillisecondsPerStep = 1000.0 * pusht::kControlStep;

/// Whether an engine surely gains success, so that there is no loss to compare.
bool gains(const EngineEquivalents& engine) { return engine.lost.interval.high < 0.0; }

json rateJson(const SuccessRate& success) {
  return {{"rate", readable(success.rate)}, {"interval", readableJson(success.interval)}};
}

/// Size of the error; NaN where there is none to say: the engine gains success, or a size of the error does.
Estimate errorOf(const EngineEquivalents& engine, const Equivalent& equivalent) {
  const bool has_none = gains(engine) || equivalent.rises_at;
  return has_none ? Estimate{} : Estimate{equivalent.error.value, equivalent.error.interval};
}

/// Number with three significant digits; "> 8" beyond the largest that was tried.
std::string sizeText(double size, double largest) {
  std::ostringstream text;
  text.precision(3);
  std::isfinite(size) ? text << size : text << "> " << largest;
  return text.str();
}

/// "3.2 [2.8, 3.6]"
std::string errorText(const EquivalentSize& error, double largest, double factor) {
  return sizeText(factor * error.value, factor * largest) + " [" +
         sizeText(factor * error.interval.low, factor * largest) + ", " +
         sizeText(factor * error.interval.high, factor * largest) + "]";
}

double largestOf(const Equivalent& equivalent) { return std::abs(equivalent.levels.back().size - equivalent.without); }

/// "loop.action_delay + 3.2 [2.8, 3.6] control steps, 320 ms [280, 360]"
std::string textOf(const Equivalent& equivalent) {
  const bool falls = equivalent.levels.back().size < equivalent.without;
  const double largest = largestOf(equivalent);
  if (equivalent.rises_at) {
    return equivalent.parameter + ": none, success rises at " + (falls ? "- " : "+ ") +
           sizeText(*equivalent.rises_at, largest) + (equivalent.unit.empty() ? "" : " " + equivalent.unit);
  }
  std::string text = equivalent.parameter + (falls ? " - " : " + ") + errorText(equivalent.error, largest, 1.0);
  if (!equivalent.unit.empty()) {
    text += " " + equivalent.unit;
  }
  if (equivalent.unit == kSteps) {
    text += ", " + errorText(equivalent.error, largest, kMillisecondsPerStep) + " ms";
  }
  return text;
}

}  // namespace

json toJson(const Equivalents& equivalents) {
  json engines = json::array();
  for (const EngineEquivalents& engine : equivalents.engines) {
    json errors = json::array();
    for (const Equivalent& equivalent : engine.equivalents) {
      json levels = json::array();
      for (const ErrorLevel& level : equivalent.levels) {
        levels.push_back({{"size", level.size}, {"success", rateJson(level.success)}});
      }
      const Estimate error = errorOf(engine, equivalent);
      addFigure(errors.emplace_back(json{{"parameter", equivalent.parameter},
                                         {"unit", equivalent.unit},
                                         {"without", equivalent.without},
                                         {"levels", levels},
                                         {"rises_at", orNull(equivalent.rises_at)}}),
                "error", "", error.value, error.interval);
    }
    addFigure(engines.emplace_back(
                  json{{"engine", engine.engine}, {"success", rateJson(engine.success)}, {"equivalents", errors}}),
              "lost", "", engine.lost.value, engine.lost.interval);
  }
  return {{"format", kEquivalentFormat},  {"confidence", kConfidence},        {"reference", equivalents.reference},
          {"policy", equivalents.policy}, {"episodes", equivalents.episodes}, {"engines", engines}};
}

std::string toCsv(const Equivalents& equivalents) {
  std::ostringstream csv;
  csv << "engine,parameter,unit,size,success,success_low,success_high,error,error_low,error_high\n";
  for (const EngineEquivalents& engine : equivalents.engines) {
    for (const Equivalent& equivalent : engine.equivalents) {
      const Estimate error = errorOf(engine, equivalent);
      for (const ErrorLevel& level : equivalent.levels) {
        const Interval success = level.success.interval.value_or(Interval{level.success.rate, level.success.rate});
        csv << csvText(engine.engine) << ',' << equivalent.parameter << ',' << csvText(equivalent.unit) << ','
            << csvNumber(level.size) << ',' << csvFigure(level.success.rate, success) << ','
            << csvFigure(error.value, error.interval) << '\n';
      }
    }
  }
  return csv.str();
}

std::string table(const Equivalents& equivalents) {
  constexpr int kDigits = 3;
  std::ostringstream text;
  text << "policy " << equivalents.policy << ", " << equivalents.episodes << " episodes; errors of "
       << equivalents.reference << " that cost it as much success:\n";
  for (const EngineEquivalents& engine : equivalents.engines) {
    const Interval& lost = engine.lost.interval;
    text << engine.engine << ": success " << cell(engine.success) << ", lost "
         << signedText(engine.lost.value, lost, "", kDigits) << '\n';
    if (gains(engine)) {
      text << "  (it gains success: no loss has an equivalent)\n";
      continue;
    }
    for (const Equivalent& equivalent : engine.equivalents) {
      text << "  " << textOf(equivalent) << '\n';
    }
    if (lost.low <= 0.0) {
      text << "  (that it loses success is not shown)\n";
    }
  }
  return text.str();
}

}  // namespace sim2sim
