// SPDX-License-Identifier: BSD-3-Clause
/// What a run says: its metrics, its rows, its table.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pusht_engine/two_mass_engine.hpp"
#include "sim2sim_eval/protocol.hpp"
#include "sim2sim_eval/statistics.hpp"

namespace sim2sim {

/// What decides the bytes of metrics.json and episodes.csv.
struct RunConfiguration {
  Protocol protocol;
  pusht::TwoMassParameters knobs;
  std::string policy;  ///< the string given, or "fresh-untrained"
  bool smoke = false;
  int nominal_episodes = 50;  ///< as the configuration hash counts them: a smoke run keeps the default
};

/// First 12 hex digits of the md5 of `episodes|pusher_mass|block_damp|baumgarte|horizon` as Python prints them.
std::string configurationHash(const RunConfiguration& configuration);

struct SuccessRate {
  int successes;
  double rate;
  Interval interval;
};

struct Summary {
  int episodes;
  SuccessRate reference;
  SuccessRate engine;
  std::optional<double> transfer;  ///< engine over reference success; none if the reference never succeeds
  Mean position_divergence;        ///< [m] of the replay, over episodes
  Mean angle_divergence;           ///< [rad]
};

/// Of at least one episode, in index order.
Summary summarize(const std::vector<EpisodeResult>& episodes);

/// The configuration as JSON; part of metrics.json and of provenance.json.
nlohmann::json describe(const RunConfiguration& configuration);

/// metrics.json: the course's keys and ours, rounded to six decimals.
nlohmann::json metrics(const RunConfiguration& configuration, const Summary& summary);

/// The text of a JSON file: sorted keys, indent 2, ASCII.
std::string jsonText(const nlohmann::json& json);

/// episodes.csv: one row per episode and mode, reals in shortest round-trip form.
std::string episodesCsv(const std::vector<EpisodeResult>& episodes);

/// The table that `compare` prints.
std::string table(const Summary& summary);

}  // namespace sim2sim
