// SPDX-License-Identifier: BSD-3-Clause
#include "answers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>

#include "pusht_task/joined.hpp"
#include "sim2sim_protocol/results/headline.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {
namespace {

using nlohmann::json;

json valueOf(const RunResults& run, const std::string& parameter) {
  return run.engine().at("parameters").value(parameter, json());
}

/// "6", "true", "simple"
std::string prose(const json& value) {
  if (value.is_string()) {
    return value.get<std::string>();
  }
  const std::string text = value.dump();
  const std::size_t fraction = text.rfind(".0");
  return fraction != std::string::npos && fraction + 2 == text.size() ? text.substr(0, fraction) : text;
}

bool areOfOneKind(const std::vector<RunResults>& runs) {
  return std::all_of(runs.begin(), runs.end(), [&](const RunResults& run) {
    return run.engine().at("name") == runs.front().engine().at("name");
  });
}

/// The parameters in which those of `runs` differ that are of the kind of `run`.
std::vector<std::string> differing(const std::vector<RunResults>& runs, const RunResults& run) {
  std::vector<std::string> names;
  const json& engine = run.engine();
  for (const auto& [name, value] : engine.at("parameters").items()) {
    const auto differs = [&, &name = name, &value = value](const RunResults& other) {
      return other.engine().at("name") == engine.at("name") && valueOf(other, name) != value;
    };
    if (std::any_of(runs.begin(), runs.end(), differs)) {
      names.push_back(name);
    }
  }
  return names;
}

/// "a, b and c"
std::string listed(std::vector<std::string> words, const char* link = " and ") {
  if (words.size() < 2) {
    return pusht::joined(words);
  }
  const std::string last = words.back();
  words.pop_back();
  return pusht::joined(words) + link + last;
}

/// Parameters that the runs vary, and the words for each run in a sentence.
struct Labels {
  std::string parameter;           ///< the only one that varies; empty if there is another number of them
  std::string baseline;            ///< "block_damp 2", "the baseline", "the two-mass engine"
  std::string place;               ///< the word before a name: "at", "with", "in"
  std::vector<std::string> names;  ///< of each run: its value, how it differs from the baseline, or its title
};

/// Parameters in which a run differs from one of its kind: "drag true", "drag true + shape true".
std::string differenceOf(const RunResults& run, const RunResults& baseline) {
  constexpr std::size_t kMost = 3;
  const std::vector<std::string> names = differing({baseline}, run);
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) {
    text.append(i == 0 ? "" : " + ").append(names[i]).append(" ").append(prose(valueOf(run, names[i])));
  }
  return text + (names.size() > kMost ? " + " + std::to_string(names.size() - kMost) + " more" : "");
}

Labels labelsOf(const std::vector<RunResults>& runs) {
  const RunResults& baseline = runs.front();
  const std::vector<std::string> varied = areOfOneKind(runs) ? differing(runs, baseline) : std::vector<std::string>();
  Labels labels;
  if (varied.size() == 1) {
    labels = {varied.front(), varied.front() + " " + prose(valueOf(baseline, varied.front())), "at", {}};
    std::transform(runs.begin(), runs.end(), std::back_inserter(labels.names),
                   [&](const RunResults& run) { return prose(valueOf(run, varied.front())); });
  } else if (varied.size() > 1) {
    labels = {"", "the baseline", "with", {}};
    std::transform(runs.begin(), runs.end(), std::back_inserter(labels.names),
                   [&](const RunResults& run) { return differenceOf(run, baseline); });
  } else {
    labels = {"", "", "in", titlesOf(runs)};
    std::transform(labels.names.begin(), labels.names.end(), labels.names.begin(), inSentence);
    labels.baseline = labels.names.front();
  }
  return labels;
}

double rateOf(const RunResults& run, Mode mode) {
  const auto successes = std::count_if(run.episodes.begin(), run.episodes.end(),
                                       [mode](const EpisodeResult& episode) { return episode.rollouts[mode].success; });
  return static_cast<double>(successes) / static_cast<double>(run.episodes.size());
}

/// "At every block_damp (2, 6, 20 and 60) the policy succeeds in 8 to 22 % of 50 episodes, in MuJoCo in 60 %."
std::string ratesOf(const std::vector<RunResults>& runs, const Labels& labels) {
  constexpr std::size_t kMostValues = 6;
  std::vector<double> rates;
  std::transform(runs.begin(), runs.end(), std::back_inserter(rates),
                 [](const RunResults& run) { return rateOf(run, kEngineClosed); });
  const auto [least, most] = std::minmax_element(rates.begin(), rates.end());
  const std::string low = percentNumber(*least);
  const std::string high = percentNumber(*most);
  std::string where = "In these " + std::to_string(runs.size()) + " runs";
  if (!labels.parameter.empty()) {
    where = "At every " + labels.parameter + (runs.size() <= kMostValues ? " (" + listed(labels.names) + ")" : "");
  }
  const SimulatorRecord reference = simulatorFrom(runs.front().metrics.at("simulators").at("reference"));
  return where + " the policy succeeds in " + (low == high ? low : low + " to " + high) + " % of " +
         std::to_string(runs.front().episodes.size()) + " episodes, in " + inSentence(reference.title) + " in " +
         percent(rateOf(runs.front(), kReferenceClosed)) + ".";
}

/// A figure of a contrast that a reader asks for first.
struct Figure {
  const char* name;  ///< in a sentence
  const char* row;   ///< of a ContrastRow
  int digits;
};

constexpr std::array kFigures = {Figure{"success", kSuccessRow, 3},
                                 Figure{"the position divergence", "mean_pos_divergence", 4},
                                 Figure{"the angle divergence", "mean_ang_divergence", 4}};

/// "the position divergence falls by 0.0069 m [0.0024, 0.0114]"
std::string clauseOf(const ContrastRow& row, const Figure& figure) {
  const std::string name = figure.name;
  const Difference& change = row.difference;
  if (!change.p) {
    return std::string("there are ") + kTooFewToCompare + " " + name;
  }
  if (change.value == 0.0 && *change.p >= 1.0 && (!change.interval || change.interval->low == change.interval->high)) {
    return name + " is the same";
  }
  if (!row.isFinding()) {
    const bool by_chance = *change.p <= 1.0 - kConfidence;  // as one of many
    return name + " is not shown to change (" + signedText(change.value, change.interval, row.unit, figure.digits) +
           (by_chance ? ", after Holm p " + probabilityText(*row.adjusted_p) : "") + ")";
  }
  const bool falls = change.value < 0.0;
  const auto size = [&](double end) { return falls ? -end : end; };
  std::optional<Interval> interval = change.interval;
  if (interval && falls) {
    interval = Interval{-interval->high, -interval->low};
  }
  const std::string text = signedText(size(change.value), interval, row.unit, figure.digits);
  return name + (falls ? " falls by " : " rises by ") + text.substr(1);  // without its plus
}

/// Runs for which something holds: "at 6, 20 and 60", "at every other value", "with drag true", "in 5 of the 12
/// others".
std::string placeOf(const std::vector<std::string>& names, std::size_t of, const Labels& labels) {
  constexpr std::size_t kMost = 4;
  if (names.size() == of) {
    return labels.parameter.empty() ? "in all others" : "at every other value";
  }
  if (names.size() > kMost) {
    return "in " + std::to_string(names.size()) + " of the " + std::to_string(of) + " others";
  }
  return labels.place + " " + listed(names);
}

/// "Against block_damp 2 the position divergence falls at 6, 20 and 60; success is not shown to change."
std::string changesOf(const std::vector<Contrast>& contrasts, const Labels& labels) {
  std::vector<std::string> clauses;
  std::vector<std::string> not_shown;
  for (const Figure& figure : kFigures) {
    std::array<std::vector<std::string>, 2> where;  // falls, rises
    for (std::size_t i = 0; i < contrasts.size(); ++i) {
      if (const ContrastRow& row = contrasts[i].row(figure.row); row.isFinding()) {
        where[row.difference.value < 0.0 ? 0 : 1].push_back(labels.names[i + 1]);
      }
    }
    std::vector<std::string> parts;
    for (const auto& [names, verb] : {std::pair(where[0], " falls "), std::pair(where[1], " rises ")}) {
      if (!names.empty()) {
        parts.push_back((parts.empty() ? figure.name : std::string()) + verb +
                        placeOf(names, contrasts.size(), labels));
      }
    }
    if (parts.empty()) {
      not_shown.emplace_back(figure.name);
    } else {
      clauses.push_back(pusht::joined(parts, " and"));
    }
  }
  if (!not_shown.empty()) {
    clauses.push_back("no change of " + listed(not_shown, " or ") + " is shown");
  }
  return "Against " + labels.baseline + ", " + pusht::joined(clauses, "; ") + ".";
}

bool areSwitches(const std::vector<RunResults>& runs) {
  if (!areOfOneKind(runs)) {
    return false;
  }
  const std::vector<std::string> names = differing(runs, runs.front());
  return names.size() > 1 && runs.size() == std::size_t{1} << names.size() &&
         std::all_of(names.begin(), names.end(),
                     [&](const std::string& name) { return valueOf(runs.front(), name).is_boolean(); });
}

}  // namespace

std::vector<RunResults> allOf(const RunResults& baseline, const std::vector<RunResults>& others) {
  std::vector<RunResults> runs = {baseline};
  runs.insert(runs.end(), others.begin(), others.end());
  return runs;
}

std::vector<std::string> titlesOf(const std::vector<RunResults>& runs) {
  constexpr std::size_t kMost = 3;  // of those that are named to tell runs apart only
  std::vector<std::string> titles;
  for (const RunResults& run : runs) {
    const std::vector<std::string> changed = run.engine().at("changed");
    std::vector<std::string> more;
    for (const std::string& name : differing(runs, run)) {
      if (std::find(changed.begin(), changed.end(), name) == changed.end()) {
        more.push_back(name);
      }
    }
    std::string title = run.title();
    for (std::size_t i = 0; i < std::min(more.size(), kMost); ++i) {
      title.append(", ").append(more[i]).append(" ").append(valueOf(run, more[i]).dump());
    }
    titles.push_back(title + (more.size() > kMost ? " and " + std::to_string(more.size() - kMost) + " more" : ""));
  }
  return titles;
}

Answer answerOf(const RunResults& baseline, const std::vector<RunResults>& others,
                const std::vector<Contrast>& contrasts) {
  if (contrasts.front().policies) {
    return policyAnswer(baseline, others, contrasts);
  }
  const std::vector<RunResults> runs = allOf(baseline, others);
  const Labels labels = labelsOf(runs);
  const std::string question =
      labels.parameter.empty() ? "What differs between the runs?" : "What does " + labels.parameter + " change?";
  const std::string changes =
      others.size() == 1 ? sentenceOf(baseline, others.front(), contrasts.front()) : changesOf(contrasts, labels);
  return {question, ratesOf(runs, labels) + " " + changes +
                        (areSwitches(runs) ? " `attribute` says how much of the gap each switch explains." : "")};
}

std::string sentenceOf(const RunResults& baseline, const RunResults& other, const Contrast& contrast) {
  if (contrast.policies) {
    return policySentence(baseline, other, contrast);
  }
  const Labels labels = labelsOf({baseline, other});
  std::vector<std::string> clauses;
  std::transform(kFigures.begin(), kFigures.end(), std::back_inserter(clauses),
                 [&](const Figure& figure) { return clauseOf(contrast.row(figure.row), figure); });
  const std::string name = (labels.parameter.empty() ? "" : labels.parameter + " ") + labels.names[1];
  return "Against " + labels.baseline + ", with " + name + " " + pusht::joined(clauses, "; ") + ".";
}

}  // namespace sim2sim
