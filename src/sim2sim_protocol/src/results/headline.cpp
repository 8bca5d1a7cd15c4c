// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/headline.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "pusht_task/joined.hpp"
#include "pusht_task/loop.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/task.hpp"
#include "sim2sim_protocol/results/text.hpp"
#include "sim2sim_statistics/sequential.hpp"

namespace sim2sim {
namespace {

constexpr const char* kQuestion = "Does the skill transfer?";
constexpr const char* kTooEarly = "Cannot say yet";

/// The answer's first words, those of `verdict` with what more the interval says.
std::string wordsOf(TransferVerdict verdict, const Interval& transfer) {
  switch (verdict) {
    case TransferVerdict::kExceeds:
      return "More, not alike";
    case TransferVerdict::kTransfers:
      return "Yes";
    case TransferVerdict::kTransfersInPart:
      return "In part";
    case TransferVerdict::kAtMostInPart:
      return "At most in part";
    case TransferVerdict::kDoesNotTransfer:
      return "No";
    default:
      return transfer.low < kNotEnough ? kTooEarly : std::string(kTooEarly) + ", but at least in part";
  }
}

/// "So far no" for "No"
std::string soFar(std::string words) {
  words[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(words[0])));
  return "So far " + words;
}

/// "31 % [30, 32]", "60 % [3 or more]"
std::string shareText(const RunConfiguration& configuration, double share, const Interval& interval) {
  const std::string low = transferNumber(configuration, interval.low);
  return transferNumber(configuration, share) + " % [" +
         (std::isinf(interval.high) ? low + " or more" : low + ", " + transferNumber(configuration, interval.high)) +
         "]";
}

/// The two ends as they are printed, so that words and figures are of the same numbers.
Interval asPrinted(const Interval& interval) {
  return {readable(interval.low), std::isinf(interval.high) ? interval.high : readable(interval.high)};
}

std::string counted(int episodes) { return std::to_string(episodes) + (episodes == 1 ? " episode" : " episodes"); }

/// Headline of too few starts; without repeats they are episodes.
Headline tooFew(int starts, int repeats) {
  const std::string fewest = "; it takes " + std::to_string(kFewestEpisodes) + " or more.";
  const std::string count =
      repeats == 1 ? counted(starts) : std::to_string(starts) + (starts == 1 ? " start" : " starts");
  const std::string answer = starts == 0 ? "no episode has finished" : count + " can say nothing";
  return {TransferVerdict::kCannotSay, kQuestion, "", std::string(kTooEarly) + ": " + answer + fewest};
}

/// "Box2D (preset idiomatic, slop true, and 3 more)": a simulator in a sentence with what is changed of it.
std::string namedWith(const SimulatorRecord& simulator, const std::string& name) {
  constexpr std::size_t kMost = 2;
  std::vector<std::string> changed;
  for (const std::string& parameter : simulator.changed) {
    if (pusht::loopParameterOf(parameter).empty()) {
      const nlohmann::ordered_json& value = simulator.parameters.at(parameter);
      changed.push_back(parameter + " " + (value.is_string() ? value.get<std::string>() : value.dump()));
    }
  }
  if (changed.size() > kMost) {
    const std::string rest = "and " + std::to_string(changed.size() - kMost) + " more";
    changed.resize(kMost);
    changed.push_back(rest);
  }
  return name + (changed.empty() ? "" : " (" + pusht::joined(changed) + ")");
}

/// Names of both simulators in a sentence, and the loop that they share: " in the loop tracker".
struct Names {
  explicit Names(const RunConfiguration& configuration) {
    const bool same = configuration.engine.title == configuration.reference.title;
    reference = namedWith(configuration.reference, same ? "the reference" : inSentence(configuration.reference.title));
    engine = namedWith(configuration.engine, same ? "the engine" : inSentence(configuration.engine.title));
    const std::string of_reference = textOf(loopOf(configuration.reference));
    const std::string of_engine = textOf(loopOf(configuration.engine));
    if (of_reference == of_engine) {
      loop = of_reference.empty() ? "" : " in the loop " + of_reference;
    } else {
      engine += " in " + (of_engine.empty() ? "a plain loop" : "the loop " + of_engine);
      reference += " in " + (of_reference.empty() ? "a plain loop" : "the loop " + of_reference);
    }
  }

  std::string reference;
  std::string engine;
  std::string loop;  ///< shared by both; empty: plain, or each has its own
};

/// What to know before the answer: that the policy's commands are clipped, if most are; how many failures of a role are
/// stuck, if these are most of at least kFewestEpisodes.
std::string caveatOf(const RunConfiguration& configuration, const Names& names, const EndingsOfPairs& endings) {
  if (const double share = std::max(endings.reference.limitedShare(), endings.engine.limitedShare());
      share > kMostLimited) {
    return percent(share) +
           " of the policy's commands are at the limit of 1 m/s, where they are clipped: does it answer in m/s?";
  }
  std::string stuck;
  bool quiet = true;
  for (const auto& [role, name] : {std::pair(&endings.reference, names.reference), {&endings.engine, names.engine}}) {
    if (role->failures() >= kFewestEpisodes && role->areMostlyStuck()) {
      quiet = quiet && !hasNoisyLoop(role == &endings.reference ? configuration.reference : configuration.engine);
      stuck += (stuck.empty() ? "" : " and ") + std::to_string(role->of(Ending::kStuck)) + " of " +
               std::to_string(role->failures()) + " in " + name;
    }
  }
  if (stuck.empty()) {
    return "";
  }
  return quiet ? "In a loop without noise most failures are stuck, " + stuck +
                     ": --loop tracker asks again with a sensor's noise."
               : "Most failures are stuck, " + stuck + ": the tee lies still to the end.";
}

}  // namespace

std::string nameOf(TransferVerdict verdict) {
  constexpr std::array kNames = {"exceeds",           "transfers",  "transfers_in_part",   "at_most_in_part",
                                 "does_not_transfer", "cannot_say", "nothing_to_transfer", "not_asked"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

TransferVerdict verdictOf(const Interval& transfer) {
  if (transfer.low > kMore) {
    return TransferVerdict::kExceeds;
  }
  if (transfer.low >= kWhole) {
    return TransferVerdict::kTransfers;
  }
  if (transfer.high <= kNotEnough) {
    return TransferVerdict::kDoesNotTransfer;
  }
  if (transfer.high >= kWhole) {
    return TransferVerdict::kCannotSay;
  }
  return transfer.low >= kNotEnough ? TransferVerdict::kTransfersInPart : TransferVerdict::kAtMostInPart;
}

std::optional<Interval> transferInterval(const Protocol& protocol, const Outcomes& outcomes) {
  return protocol.until_decided ? std::optional(transferSequence(outcomes.table)) : outcomes.transfer_interval;
}

std::string transferNumber(const RunConfiguration& configuration, double share) {
  constexpr int kMostDigits = 4;  // further ones decide nothing
  constexpr double kHundred = 100.0;
  const double exact = readable(share);
  const auto is_on_its_side = [&](const std::string& text, double bound) {
    const double shown = pusht::decimal<double>(text).value() / kHundred;
    return (shown < bound) == (exact < bound) && (shown > bound) == (exact > bound);
  };
  for (int digits = 0; digits < kMostDigits; ++digits) {
    std::string text = pusht::fixedText(kHundred * exact, digits);
    const double deciding = configuration.protocol.until_decided.value_or(kNotEnough);
    if (is_on_its_side(text, kNotEnough) && is_on_its_side(text, kWhole) && is_on_its_side(text, kMore) &&
        is_on_its_side(text, deciding)) {
      return text;
    }
  }
  return pusht::fixedText(kHundred * exact, kMostDigits);
}

namespace {

/// "In 62 % [48, 74] of 50 episodes in MuJoCo.": of a run without an engine. With repeats the table has the interval.
Headline headlineAlone(const RunConfiguration& configuration, const Outcomes& outcomes, const EndingsOfPairs& endings) {
  const int episodes = outcomes.table.pairs();
  if (episodes == 0) {
    return tooFew(0, configuration.protocol.repeats);
  }
  const int successes = outcomes.table.both + outcomes.table.first_only;
  const Names names(configuration);
  const std::optional<Interval> interval =
      configuration.protocol.repeats == 1 ? std::optional(wilsonInterval(successes, episodes)) : std::nullopt;
  return {TransferVerdict::kNotAsked, "How often does the policy succeed?", caveatOf(configuration, names, endings),
          "In " + percent(successes / static_cast<double>(episodes), interval) + " of " + counted(episodes) + " in " +
              names.reference + names.loop + "."};
}

}  // namespace

Headline headlineOf(const RunConfiguration& configuration, const Outcomes& outcomes, const EndingsOfPairs& endings) {
  if (configuration.protocol.alone) {
    return headlineAlone(configuration, outcomes, endings);
  }
  const PairTable& successes = outcomes.table;
  const int episodes = successes.pairs();
  const int reference_successes = successes.both + successes.first_only;
  const bool has_sequence = configuration.protocol.until_decided && reference_successes > 0;  // holds from the first on
  if (outcomes.starts < kFewestEpisodes && !has_sequence) {
    return tooFew(outcomes.starts, configuration.protocol.repeats);
  }
  const Names names(configuration);
  const std::string with = ": with this policy" + names.loop + " ";
  const std::string caveat = caveatOf(configuration, names, endings);
  const bool partial = !configuration.protocol.until_decided && episodes < configuration.protocol.episodes;
  const std::string count =
      partial ? " (" + std::to_string(episodes) + " of " + counted(configuration.protocol.episodes) + ")." : ".";
  if (reference_successes == 0) {
    const std::string words = "Nothing to transfer";
    return {TransferVerdict::kNothingToTransfer, kQuestion, caveat,
            (partial ? soFar(words) : words) + with + names.reference + " never succeeds" +
                (partial ? count : " in " + counted(episodes) + ".")};
  }
  const Interval interval = asPrinted(transferInterval(configuration.protocol, outcomes).value());
  const TransferVerdict verdict = verdictOf(interval);
  const std::string words = wordsOf(verdict, interval);
  const double transfer = (successes.both + successes.second_only) / static_cast<double>(reference_successes);
  return {verdict, kQuestion, caveat,
          (partial && verdict != TransferVerdict::kCannotSay ? soFar(words) : words) + with + names.engine +
              (transfer > 1.0 ? " has " : " keeps ") + shareText(configuration, transfer, interval) + " of " +
              names.reference + "'s success" +
              (verdict == TransferVerdict::kExceeds ? ", which is another task, not a better skill" : "") + count};
}

nlohmann::json toJson(const Headline& headline) {
  return {{"verdict", nameOf(headline.verdict)},
          {"question", headline.question},
          {"caveat", headline.caveat},
          {"answer", headline.answer}};
}

std::string inSentence(const std::string& title) {
  const std::string kind = "engine";
  const std::string head = title.substr(0, title.find(','));  // without parameters
  const bool is_noun = head.size() > kind.size() && head.compare(head.size() - kind.size(), kind.size(), kind) == 0;
  return is_noun ? "the " + title : title;
}

}  // namespace sim2sim
