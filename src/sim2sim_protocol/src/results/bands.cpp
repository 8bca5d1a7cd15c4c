// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/bands.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "pusht_task/numbers.hpp"

namespace sim2sim {
namespace {

constexpr double kLeast = 1e-12;     // [m or rad] what is below counts as 0
constexpr double kGreatest = 100.0;  // [m or rad] what is above counts as that
constexpr double kRatio = 1.02;      // of a bin's edges
constexpr std::array kQuantiles = {0.05, 0.25, 0.5, 0.75, 0.95};

/// 0 for what counts as 0.
std::size_t binOf(double divergence) {
  return divergence < kLeast
             ? 0
             : 1 + static_cast<std::size_t>(std::log(std::min(divergence, kGreatest) / kLeast) / std::log(kRatio));
}

/// The geometric middle of a bin.
double valueOf(std::size_t bin) { return bin == 0 ? 0.0 : kLeast * std::pow(kRatio, static_cast<double>(bin) - 0.5); }

/// The value that the share `p` of all counted ones does not exceed.
double rankedValue(const std::vector<std::uint32_t>& bins, std::uint64_t total, double p) {
  const auto rank = static_cast<std::uint64_t>(std::ceil(p * static_cast<double>(total)));
  std::uint64_t seen = 0;
  std::size_t bin = 0;
  while (bin + 1 < bins.size() && (seen += bins[bin]) < rank) {
    ++bin;
  }
  return valueOf(bin);
}

}  // namespace

nlohmann::json toJson(const EpisodeBins& bins) {
  constexpr const char* kHexDigits = "0123456789abcdef";
  nlohmann::json lists = nlohmann::json::array();
  for (const auto& rollout : bins) {
    for (const std::vector<std::uint16_t>& component : rollout) {
      std::string text;
      for (const unsigned int bin : component) {
        for (const unsigned int shift : {12U, 8U, 4U, 0U}) {
          text += kHexDigits[bin >> shift & 15U];
        }
      }
      lists.push_back(std::move(text));
    }
  }
  return lists;
}

EpisodeBins binsFrom(const nlohmann::json& json) {
  constexpr std::size_t kDigits = 4;
  constexpr int kBase = 16;
  const auto lists = json.get<std::vector<std::string>>();
  EpisodeBins bins(lists.size() / 2);
  for (std::size_t i = 0; i < 2 * bins.size(); ++i) {
    for (std::size_t at = 0; at + kDigits <= lists[i].size(); at += kDigits) {
      bins[i / 2].at(i % 2).push_back(
          static_cast<std::uint16_t>(std::stoul(lists[i].substr(at, kDigits), nullptr, kBase)));
    }
  }
  return bins;
}

DivergenceBands::DivergenceBands(const Protocol& protocol) : protocol_(protocol) {
  const std::vector<std::string> names = protocol.rolloutNames();
  for (std::size_t rollout = kReferenceClosed + 1; rollout < names.size(); ++rollout) {
    curves_.push_back({names[rollout], {}});
  }
}

EpisodeBins DivergenceBands::binsOf(const Protocol& protocol, const Episode& episode) {
  const pusht::Trace& reference = episode.rollout(kReferenceClosed).trace();
  EpisodeBins bins;
  const std::size_t rollouts = rolloutOfProbe(protocol.probes().size());
  for (std::size_t rollout = kReferenceClosed + 1; rollout < rollouts; ++rollout) {
    auto& of_rollout = bins.emplace_back();
    if (!protocol.isFlown(rollout)) {
      continue;
    }
    for (const Divergence& divergence : divergenceBySteps(reference, episode.trace(rollout))) {
      for (std::size_t i = 0; i < kComponents.size(); ++i) {
        of_rollout[i].push_back(static_cast<std::uint16_t>(binOf(divergence.*kComponents[i])));
      }
    }
  }
  return bins;
}

void DivergenceBands::add(const EpisodeBins& bins) {
  for (std::size_t rollout = 0; rollout < curves_.size(); ++rollout) {
    Curve& curve = curves_[rollout];
    for (std::size_t i = 0; i < kComponents.size(); ++i) {
      const std::vector<std::uint16_t>& steps = bins.at(rollout)[i];
      curve.steps.resize(std::max(curve.steps.size(), steps.size()));
      for (std::size_t step = 0; step < steps.size(); ++step) {
        Bins& counts = curve.steps[step][i];
        counts.resize(std::max<std::size_t>(counts.size(), steps[step] + 1U));
        ++counts[steps[step]];
      }
    }
  }
}

std::string DivergenceBands::csv() const {
  constexpr std::array<const char*, kComponents.size()> kColumns = {"position", "angle"};
  constexpr std::array<const char*, kComponents.size()> kUnits = {"m", "rad"};
  std::string text = "mode,step,episodes";
  for (std::size_t i = 0; i < kComponents.size(); ++i) {
    for (const double p : kQuantiles) {
      text += std::string(",") + kColumns[i] + "_" + pusht::fixedText(p, 2) + "_" + kUnits[i];
    }
  }
  text += "\n";
  for (const Curve& curve : curves_) {
    for (std::size_t step = 0; step < curve.steps.size(); ++step) {
      const Bins& bins = curve.steps[step].front();
      const std::uint64_t episodes = std::accumulate(bins.begin(), bins.end(), std::uint64_t{0});
      text += curve.mode + "," + std::to_string(step) + "," + std::to_string(episodes);
      for (const Bins& component : curve.steps[step]) {
        for (const double p : kQuantiles) {
          constexpr int kDigits = 3;  // more would pretend
          text += "," + pusht::significantText(rankedValue(component, episodes, p), kDigits);
        }
      }
      text += "\n";
    }
  }
  return text;
}

}  // namespace sim2sim
