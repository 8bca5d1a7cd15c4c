// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/episodes_csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/split.hpp"

namespace sim2sim {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kFixedColumns = 5;            // before the quantities
constexpr std::size_t kFirstDivergenceColumns = 3;  // behind the quantities; with repeats one more follows
constexpr std::size_t kEndingColumns = 3;           // the last ones

template <class Number>
Number numberFrom(const std::string& text) {
  Number number{};
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;  // what is not all of a number does not give the same text again
}

/// Rollouts that have a row.
std::vector<std::size_t> flownRollouts(const Protocol& protocol) {
  std::vector<std::size_t> flown;
  for (std::size_t rollout = 0; rollout < protocol.rolloutNames().size(); ++rollout) {
    if (protocol.isFlown(rollout)) {
      flown.push_back(rollout);
    }
  }
  return flown;
}

std::string csvHead(const Protocol& protocol) {
  std::string head = "episode,seed,mode,steps,success";
  for (const std::size_t i : protocol.quantityColumns()) {
    head.append(",").append(kQuantities[i].name).append("_").append(kQuantities[i].unit);
  }
  return head + ",parting_step,parting_cause,parting_first" + (protocol.repeats > 1 ? ",repeat" : "") +
         ",ending,still_step,pusher_ending\n";
}

std::string csvRow(const Protocol& protocol, const EpisodeResult& episode, const std::string& mode,
                   const RolloutResult& result) {
  const std::string success = result.success ? "true" : "false";
  std::string row = std::to_string(episode.index) + "," + (episode.seed ? std::to_string(*episode.seed) : "") + "," +
                    mode + "," + std::to_string(result.steps) + "," + success;
  for (const std::size_t i : protocol.quantityColumns()) {
    const double value = result.quantities[i];
    row.append(",").append(std::isnan(value) ? "" : pusht::shortestText(value));
  }
  const std::optional<FirstDivergence>& divergence = result.first_divergence;
  row += divergence ? "," + std::to_string(divergence->step) + "," + nameOf(divergence->cause).name + "," +
                          nameOf(divergence->first)
                    : ",,,";
  row += protocol.repeats > 1 ? "," + std::to_string(protocol.repeat(episode.index)) : "";
  const std::optional<RolloutEnding>& end = result.ending;
  row +=
      end ? std::string(",") + nameOf(end->ending) + "," + std::to_string(end->still_step) + "," + nameOf(end->pusher)
          : ",,,";
  return row + "\n";
}

/// Lines of a text, the last of which may be incomplete.
std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines = pusht::split(text, '\n');
  if (lines.back().empty()) {
    lines.pop_back();
  }
  return lines;
}

/// Place of a name in a list of names; empty if it is not there.
template <class Names>
std::optional<std::size_t> placeIn(const Names& names, const std::string& name) {
  const auto place = std::find(names.begin(), names.end(), name);
  return place == names.end() ? std::nullopt : std::optional(static_cast<std::size_t>(place - names.begin()));
}

/// First divergence from its cells; empty if they name none.
std::optional<FirstDivergence> firstDivergenceFrom(const std::string& step, const std::string& cause,
                                                   const std::string& first) {
  const auto known = std::find_if(kCauses.begin(), kCauses.end(), [&](const auto& name) { return cause == name.name; });
  const std::optional<std::size_t> who = placeIn(kFirstBodyNames, first);
  if (known == kCauses.end() || !who) {
    return std::nullopt;
  }
  return FirstDivergence{numberFrom<int>(step), known->cause, static_cast<FirstBody>(*who)};
}

/// Ending from its cells; empty if they name none.
std::optional<RolloutEnding> endingFrom(const std::string& ending, const std::string& still_step,
                                        const std::string& pusher) {
  const std::optional<std::size_t> of_rollout = placeIn(kEndingNames, ending);
  const std::optional<std::size_t> of_pusher = placeIn(kPusherEndingNames, pusher);
  return of_rollout && of_pusher
             ? std::optional(RolloutEnding{static_cast<Ending>(*of_rollout), numberFrom<int>(still_step),
                                           static_cast<PusherEnding>(*of_pusher)})
             : std::nullopt;
}

/// The row that csvRow() wrote, as far as it can be read.
void readCsvRow(const Protocol& protocol, const std::string& row, EpisodeResult& episode, RolloutResult& result) {
  std::vector<std::string> cells = pusht::split(row, ',');
  const std::vector<std::size_t> columns = protocol.quantityColumns();
  const std::size_t after_quantities = kFixedColumns + columns.size();
  const std::size_t last = after_quantities + kFirstDivergenceColumns + (protocol.repeats > 1 ? 1 : 0);
  cells.resize(last + kEndingColumns);
  episode.index = numberFrom<int>(cells[0]);
  episode.seed = cells[1].empty() ? std::nullopt : std::optional(numberFrom<std::uint64_t>(cells[1]));
  result.steps = numberFrom<int>(cells[3]);
  result.success = cells[4] == "true";
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::string& cell = cells[kFixedColumns + i];
    result.quantities[columns[i]] = cell.empty() ? kNone : numberFrom<double>(cell);
  }
  result.first_divergence =
      firstDivergenceFrom(cells[after_quantities], cells[after_quantities + 1], cells[after_quantities + 2]);
  result.ending = endingFrom(cells[last], cells[last + 1], cells[last + 2]);
}

}  // namespace

std::string episodesCsv(const Protocol& protocol, const std::vector<EpisodeResult>& episodes) {
  const std::vector<std::string> modes = protocol.rolloutNames();
  std::string csv = csvHead(protocol);
  for (const EpisodeResult& episode : episodes) {
    for (const std::size_t i : flownRollouts(protocol)) {
      csv += csvRow(protocol, episode, modes[i], episode.rollouts.at(i));
    }
  }
  return csv;
}

std::vector<EpisodeResult> episodesFromCsv(const Protocol& protocol, const std::string& text) {
  const std::vector<std::string> lines = linesOf(text);
  if (!lines.empty() && lines.front() + "\n" != csvHead(protocol)) {
    throw pusht::InvalidInput("line 1: must have the columns that this version writes; run it again");
  }
  const std::vector<std::size_t> flown = flownRollouts(protocol);
  const std::size_t count = lines.empty() ? 0 : (lines.size() - 1) / flown.size();
  std::vector<EpisodeResult> episodes(count);
  for (std::size_t i = 0; i < count; ++i) {
    episodes[i].rollouts.resize(protocol.rolloutNames().size());
    for (std::size_t row = 0; row < flown.size(); ++row) {
      readCsvRow(protocol, lines[1 + i * flown.size() + row], episodes[i], episodes[i].rollouts[flown[row]]);
    }
  }
  const std::vector<std::string> expected = linesOf(episodesCsv(protocol, episodes));
  const auto [found, wanted] = std::mismatch(lines.begin(), lines.end(), expected.begin(), expected.end());
  if (found != lines.end() || wanted != expected.end()) {
    throw pusht::InvalidInput("line " + std::to_string(found - lines.begin() + 1) +
                              ": must be a line of episodes.csv as it was written");
  }
  return episodes;
}

}  // namespace sim2sim
