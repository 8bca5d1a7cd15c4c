// SPDX-License-Identifier: BSD-3-Clause
// Says before a run what differences it can show.
#include <CLI/CLI.hpp>
#include <array>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/contrast.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_protocol/results/text.hpp"
#include "sim2sim_statistics/planning.hpp"

namespace {

using sim2sim::RunResults;

struct Options {
  std::string pilot;
  std::string other;
  std::vector<int> episodes = {50, 200, 1000};
  std::optional<double> success;   // differences that are to be shown
  std::optional<double> position;  // [m]
  std::optional<double> angle;     // [rad]
};

/// A difference that somebody may want to show.
struct Question {
  std::string text;
  std::optional<double> deviation;   // of paired differences
  std::optional<double> discordant;  // share of pairs in which only one succeeds
  std::optional<double> wanted;
};

std::string significant(double value) {
  constexpr int kDigits = 2;
  return pusht::significantText(value, kDigits);
}

std::optional<double> deviationOf(const std::vector<double>& differences) {
  return differences.size() < 2 ? std::nullopt : std::optional(sim2sim::standardDeviation(differences));
}

/// The share of pairs in which only one succeeds.
double discordanceOf(const sim2sim::PairTable& table) {
  return (table.first_only + table.second_only) / static_cast<double>(table.pairs());
}

std::vector<Question> questionsOf(const Options& options, const RunResults& pilot,
                                  const std::optional<RunResults>& other) {
  using sim2sim::kEngineClosed;
  using sim2sim::kEngineReplay;
  using sim2sim::kReferenceClosed;
  const std::array<std::pair<std::string, std::optional<double>>, 2> names = {
      std::make_pair("position divergence [m]", options.position), {"angle divergence [rad]", options.angle}};

  std::vector<Question> questions;
  const auto success = [&](const std::string& text, const sim2sim::PairTable& table) {
    questions.push_back({text, {}, discordanceOf(table), options.success});
  };
  success("success, engine - reference",
          sim2sim::pairsOf(pilot.episodes, kReferenceClosed, pilot.episodes, kEngineClosed));
  if (other) {
    success("success, other - pilot", sim2sim::pairsOf(pilot.episodes, kEngineClosed, other->episodes, kEngineClosed));
  }
  for (std::size_t k = 0; k < sim2sim::kDivergencePairs.size(); ++k) {
    const sim2sim::FigureIndex divergence{kEngineReplay,
                                          sim2sim::quantityIndex(sim2sim::kDivergencePairs[k].divergence)};
    const sim2sim::FigureIndex null_model{kEngineReplay,
                                          sim2sim::quantityIndex(sim2sim::kDivergencePairs[k].null_model)};
    const auto spread = [&](const std::string& text, const std::vector<double>& differences) {
      questions.push_back({names.at(k).first + text, deviationOf(differences), {}, names.at(k).second});
    };
    spread(", against null model", sim2sim::differencesOf(pilot.episodes, divergence, pilot.episodes, null_model));
    if (other) {
      spread(", other - pilot", sim2sim::differencesOf(other->episodes, divergence, pilot.episodes, divergence));
    }
  }
  return questions;
}

std::string shown(const Question& question, int episodes) {
  if (question.deviation) {
    return significant(sim2sim::smallestDifference(*question.deviation, episodes));
  }
  if (!question.discordant || *question.discordant <= 0.0) {
    return "-";
  }
  const std::optional<double> least = sim2sim::smallestRateDifference(*question.discordant, episodes);
  return least ? significant(*least) : "none";
}

std::string needed(const Question& question) {
  if (!question.wanted) {
    return "";
  }
  if (!question.deviation && !question.discordant) {
    return "unknown: the pilot is too short";
  }
  const std::optional<int> episodes = question.deviation ? sim2sim::episodesFor(*question.deviation, *question.wanted)
                                      : *question.wanted <= question.discordant.value_or(0.0)
                                          ? sim2sim::episodesForRates(*question.discordant, *question.wanted)
                                          : std::nullopt;
  return significant(*question.wanted) + ": " + (episodes ? std::to_string(*episodes) + " episodes" : "none suffice");
}

void requirePositive(const std::string& name, const std::optional<double>& difference) {
  if (difference && !(*difference > 0.0)) {
    throw pusht::InvalidInput(name + " " + significant(*difference) + ": must be above 0");
  }
}

void plan(const Options& options) {
  requirePositive("success", options.success);
  requirePositive("position", options.position);
  requirePositive("angle", options.angle);
  const RunResults pilot = sim2sim::readResults(options.pilot);
  std::optional<RunResults> other;
  if (!options.other.empty()) {
    sim2sim::requireNotInterrupted();
    other = sim2sim::readResults(options.other);
    sim2sim::contrast(pilot, {*other});  // refuses what does not pair
  }
  constexpr std::size_t kText = 44;
  constexpr std::size_t kColumn = 10;
  std::ostringstream table;  // whole or not at all
  table << sim2sim::padded("smallest difference shown in [episodes]", kText);
  for (const int episodes : options.episodes) {
    table << sim2sim::padded(std::to_string(episodes), kColumn);
  }
  table << "\n";
  for (const Question& question : questionsOf(options, pilot, other)) {
    table << sim2sim::padded(question.text, kText);
    for (const int episodes : options.episodes) {
      table << sim2sim::padded(shown(question, episodes), kColumn);
    }
    table << needed(question) << "\n";
  }
  table << "(found in 80 % of runs at 5 %, two-sided; spreads as in the " << pilot.episodes.size() << " episodes of "
        << pilot.folder.string() << ")"
        << "\n";
  sim2sim::requireNotInterrupted();
  std::cout << table.str() << std::flush;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Says how small a difference a run can show, from how much the episodes of a finished run vary.",
               "plan");
  Options options;
  app.add_option("pilot", options.pilot, "folder of a run")->required()->check(sim2sim::notEmpty());
  app.add_option("other", options.other, "folder of a second run over the same episodes, to plan a contrast")
      ->check(sim2sim::notEmpty());
  app.add_option("--episodes", options.episodes, "numbers of episodes: N,N,...")->delimiter(',')->capture_default_str();
  app.add_option("--success", options.success, "a difference of success rates: how many episodes show it?")
      ->check(sim2sim::decimalReal());
  app.add_option("--position", options.position, "[m] a difference of position divergences")
      ->check(sim2sim::decimalReal());
  app.add_option("--angle", options.angle, "[rad] a difference of angle divergences")->check(sim2sim::decimalReal());
  return sim2sim::runCommand(app, argc, argv, [&] { plan(options); });
}
