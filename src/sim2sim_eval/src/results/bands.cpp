// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/results/bands.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

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

DivergenceBands::DivergenceBands(const Protocol& protocol) {
  const std::vector<std::string> names = protocol.rolloutNames();
  for (std::size_t rollout = kReferenceClosed + 1; rollout < names.size(); ++rollout) {
    curves_.push_back({names[rollout], {}});
  }
}

void DivergenceBands::add(const Episode& episode) {
  const pusht::Trace& reference = episode.rollout(kReferenceClosed).trace();
  for (std::size_t rollout = kReferenceClosed + 1; rollout <= curves_.size(); ++rollout) {
    const pusht::Trace& trace = rollout < kModeCount ? episode.rollout(static_cast<Mode>(rollout)).trace()
                                                     : episode.probe(rollout - kModeCount).value();
    add(curves_[rollout - 1], reference, trace);
  }
}

void DivergenceBands::add(Curve& curve, const pusht::Trace& reference, const pusht::Trace& rollout) {
  const std::vector<Divergence> divergences = divergenceBySteps(reference, rollout);
  curve.steps.resize(std::max(curve.steps.size(), divergences.size()));
  for (std::size_t step = 0; step < divergences.size(); ++step) {
    for (std::size_t i = 0; i < kComponents.size(); ++i) {
      Bins& bins = curve.steps[step][i];
      const std::size_t bin = binOf(divergences[step].*kComponents[i]);
      bins.resize(std::max(bins.size(), bin + 1));
      ++bins[bin];
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
