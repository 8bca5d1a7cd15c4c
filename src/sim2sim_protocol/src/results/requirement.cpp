// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/requirement.hpp"

#include <algorithm>
#include <array>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <cstddef>
#include <regex>
#include <string>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/headline.hpp"
#include "sim2sim_protocol/results/text.hpp"
#include "sim2sim_statistics/planning.hpp"

namespace sim2sim {
namespace {

constexpr const char* kReference = "reference";
constexpr const char* kEngine = "engine";
constexpr const char* kTransfer = "transfer";

[[noreturn]] void refuse(const std::string& text, const std::string& rule) {
  throw pusht::InvalidInput("requirement \"" + text + "\": " + rule);
}

/// Number of `text`, or of a text in percent.
double numberOf(const std::string& requirement, std::string text) {
  constexpr double kPercent = 100.0;
  const bool is_percent = !text.empty() && text.back() == '%';
  if (is_percent) {
    text.pop_back();
  }
  const std::optional<double> number = pusht::decimal<double>(text);
  if (!number) {
    refuse(requirement, text + " must be a decimal number");
  }
  return is_percent ? *number / kPercent : *number;
}

Requirement::Figure figureNamed(const std::string& requirement, const std::string& text) {
  Requirement::Figure figure;
  std::string name = text;
  if (text[0] >= 'A' && text[0] <= 'Z' && (text.size() == 1 || text[1] == '.')) {
    figure.run = text[0] - 'A';
    name = text.size() == 1 ? kEngine : text.substr(2);
  }
  if (name != kReference && name != kEngine && name != kTransfer) {
    refuse(requirement, text +
                            " must be reference, engine or transfer, behind the letter of a run and a point where "
                            "several runs are compared: B.transfer");
  }
  figure.name = name;
  return figure;
}

Estimate negative(const Estimate& estimate) {
  Estimate result{-estimate.value, std::nullopt};
  if (estimate.interval) {
    result.interval = Interval{-estimate.interval->high, -estimate.interval->low};
  }
  return result;
}

/// Figure of a run.
Estimate figureOf(const Requirement::Figure& figure, const Protocol& protocol, const Summary& summary) {
  if (figure.name == kTransfer) {
    return {summary.outcomes.transfer.value_or(std::nan("")),
            summary.outcomes.transfer ? transferInterval(protocol, summary.outcomes) : std::nullopt};
  }
  const SuccessRate& rate = figure.name == kEngine ? summary.engine : summary.reference;
  return {rate.rate, rate.interval};
}

/// Figure of a run, less another one of it.
Estimate foundIn(const Requirement& requirement, const Protocol& protocol, const Summary& summary) {
  if (!requirement.subtracted) {
    return figureOf(requirement.figure, protocol, summary);
  }
  const Estimate engine_less_reference{summary.outcomes.table.difference(), summary.outcomes.difference_interval};
  return requirement.figure.name == kEngine ? engine_less_reference : negative(engine_less_reference);
}

/// Number of starts after which the interval leaves the bound out in 80 % of runs, if the figure stays.
std::optional<int> startsNeeded(const Estimate& found, double bound, int starts) {
  const double distance = std::abs(found.value - bound);
  if (!found.interval || distance == 0.0) {
    return std::nullopt;
  }
  const double half = found.value > bound ? found.value - found.interval->low : found.interval->high - found.value;
  const double z = boost::math::quantile(boost::math::normal(), 0.5 * (1.0 + kConfidence));
  return std::isfinite(half) ? episodesFor(half * std::sqrt(starts) / z, distance) : std::nullopt;
}

RequirementResult judged(const Requirement& requirement, const Estimate& found, int starts) {
  RequirementResult result{requirement.text, RequirementResult::Verdict::kCannotSay, found, {}};
  if (found.interval) {
    const bool is_above = found.interval->low > requirement.bound;
    const bool is_below = found.interval->high < requirement.bound;
    if (is_above || is_below) {
      result.verdict =
          is_above == requirement.is_more ? RequirementResult::Verdict::kMet : RequirementResult::Verdict::kNotMet;
    }
  }
  if (result.verdict == RequirementResult::Verdict::kCannotSay) {
    result.starts_needed = startsNeeded(found, requirement.bound, starts);
  }
  return result;
}

int startsOf(const Protocol& protocol, int episodes) { return episodes / protocol.repeats; }

/// Row of a contrast that has a figure of two runs.
const char* rowOf(const Requirement& requirement, const Contrast& contrast) {
  const std::string& name = requirement.figure.name;
  const char* const row = name == kEngine ? kSuccessRow : name == kReference ? kReferenceSuccessRow : kTransferRow;
  if (!contrast.has(row)) {
    refuse(requirement.text, contrast.policies ? "must compare reference, as these runs have no engine"
                                               : "must compare engine, as these runs differ in their engines");
  }
  return row;
}

/// Throws InvalidInput for a bound that no figure can be beyond.
void requireReachable(const Requirement& requirement) {
  constexpr double kMostTransfer = 10.0;
  const double most = requirement.figure.name == kTransfer ? kMostTransfer : 1.0;
  const double least = requirement.subtracted ? -most : 0.0;
  if (requirement.bound < least || requirement.bound > most) {
    refuse(requirement.text, "the number must be from " + pusht::shortestText(least) + " to " +
                                 pusht::shortestText(most) + "; or in percent, as 80%");
  }
}

}  // namespace

std::string letterOf(int run) { return std::string(1, run <= 'Z' - 'A' ? static_cast<char>('A' + run) : '?'); }

Requirement::Requirement(std::string given) : text(std::move(given)) {
  static const std::regex grammar(
      R"(\s*([A-Za-z.]+)\s*([<>])\s*(?:([A-Za-z][A-Za-z.]*)\s*(?:([+-])\s*([0-9.]+%?)\s*)?|(-?[0-9.]+%?)\s*))");
  constexpr std::size_t kLongest = 200;  // characters
  std::smatch parts;
  if (text.size() > kLongest || !std::regex_match(text, parts, grammar)) {
    refuse(text.substr(0, kLongest),
           "must be as \"transfer > 0.8\", \"engine > reference - 0.1\" or, of runs, \"B > A - 0.05\"");
  }
  figure = figureNamed(text, parts[1]);
  is_more = parts[2] == ">";
  if (parts[6].matched) {
    bound = numberOf(text, parts[6]);
    requireReachable(*this);
    return;
  }
  subtracted = figureNamed(text, parts[3]);
  bound = parts[5].matched ? numberOf(text, parts[5]) * (parts[4] == "-" ? -1.0 : 1.0) : 0.0;
  requireReachable(*this);
  const bool is_of_one_run = figure.run == subtracted->run;
  if (is_of_one_run && (figure.name == subtracted->name || figure.name == kTransfer || subtracted->name == kTransfer)) {
    refuse(text, "must compare engine and reference, within a run");
  }
  if (!is_of_one_run && figure.name != subtracted->name) {
    refuse(text, "must compare the same figure of two runs");
  }
}

void Requirement::requireOneRun(const std::optional<double>& until_decided) const {
  if (figure.run || (subtracted && subtracted->run)) {
    refuse(text, "must name no run, as there is one");
  }
  if (until_decided && figure.name != kTransfer) {
    refuse(text, "must be one of transfer, the only figure with an interval in a run that ends when it is decided");
  }
  if (until_decided && bound != *until_decided) {
    refuse(text, "must have the share of --until-decided, " + pusht::shortestText(*until_decided) +
                     ", at which the run ends");
  }
}

void Requirement::requireReferenceAlone() const {
  if (figure.name != kReference || subtracted) {
    refuse(text, "must be as \"reference > 0.6\", as there is no engine");
  }
}

void Requirement::requireRuns(int runs) const {
  for (const Figure* of : {&figure, subtracted ? &*subtracted : &figure}) {
    if (!of->run || *of->run >= runs) {
      refuse(text, "must name runs by their letters, from A, as there are " + std::to_string(runs));
    }
  }
  if (subtracted && figure.run != subtracted->run && *figure.run != 0 && *subtracted->run != 0) {
    refuse(text, "must compare with A, the baseline");
  }
}

std::string RequirementResult::sentence() const {
  constexpr int kDigits = 3;
  constexpr std::array kVerdicts = {"shown", "shown otherwise", "cannot say"};
  std::string text =
      requirement + ": " + kVerdicts.at(static_cast<std::size_t>(verdict)) + ", " +
      (std::isnan(found.value) ? "the reference never succeeds" : valueText(found.value, found.interval, kDigits));
  if (std::isnan(found.value)) {
    return text;
  }
  if (verdict == Verdict::kCannotSay && may_go_on) {
    return text + "; it takes more --episodes";
  }
  if (verdict == Verdict::kCannotSay && !found.interval) {
    return text + "; it takes " + std::to_string(kFewestEpisodes) + " or more starts";
  }
  if (verdict == Verdict::kCannotSay) {
    text += "; " + (starts_needed ? std::to_string(*starts_needed) : "more than " + std::to_string(kMostEpisodes)) +
            " starts would decide";
  }
  return text;
}

RequirementResult judge(const Requirement& requirement, const Protocol& protocol, const Summary& summary) {
  RequirementResult result =
      judged(requirement, foundIn(requirement, protocol, summary), startsOf(protocol, summary.episodes));
  if (protocol.until_decided) {
    result.starts_needed.reset();  // its interval does not narrow as those of a fixed number do
    result.may_go_on = true;
  }
  return result;
}

RequirementResult judge(const Requirement& requirement, const RunResults& baseline,
                        const std::vector<RunResults>& others, const std::vector<Contrast>& contrasts) {
  const int run = *requirement.figure.run;
  const int other = requirement.subtracted ? *requirement.subtracted->run : run;
  if (run == other) {
    const RunResults& its_run = run == 0 ? baseline : others.at(static_cast<std::size_t>(run - 1));
    return judge(requirement, its_run.protocol, summarize(its_run.protocol, its_run.episodes));
  }
  const Contrast& contrast = contrasts.at(static_cast<std::size_t>(std::max(run, other) - 1));
  const Difference& difference = contrast.row(rowOf(requirement, contrast)).difference;
  const Estimate found{difference.value, difference.interval};
  return judged(requirement, other == 0 ? found : negative(found),
                startsOf(baseline.protocol, static_cast<int>(baseline.episodes.size())));
}

}  // namespace sim2sim
