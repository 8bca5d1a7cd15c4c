// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "sim2sim_protocol/results/headline.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/pairs.hpp"
#include "sim2sim_statistics/planning.hpp"
#include "sim2sim_statistics/repeats.hpp"
#include "sim2sim_statistics/sequential.hpp"
#include "sim2sim_statistics/tails.hpp"

namespace sim2sim::python {
namespace {

namespace py = pybind11;

using Counts = std::array<int, 4>;  // as PairTable
using Ends = std::pair<double, double>;
using MaybeEnds = std::optional<Ends>;
using Samples = std::vector<double>;

PairTable tableOf(const Counts& counts) { return {counts[0], counts[1], counts[2], counts[3]}; }

std::vector<PairTable> tablesOf(const std::vector<Counts>& starts) {
  std::vector<PairTable> tables;
  std::transform(starts.begin(), starts.end(), std::back_inserter(tables), tableOf);
  return tables;
}

Ends endsOf(const Interval& interval) { return {interval.low, interval.high}; }

MaybeEnds endsOf(const std::optional<Interval>& interval) {
  return interval ? MaybeEnds(endsOf(*interval)) : std::nullopt;
}

std::tuple<double, MaybeEnds> plain(const Estimate& estimate) { return {estimate.value, endsOf(estimate.interval)}; }

std::tuple<double, MaybeEnds, std::optional<double>> plain(const Difference& difference) {
  return {difference.value, endsOf(difference.interval), difference.p};
}

/// Successes and episodes of each start.
std::vector<StartCount> startsOf(const std::vector<std::pair<int, int>>& counts) {
  std::vector<StartCount> starts;
  std::transform(counts.begin(), counts.end(), std::back_inserter(starts), [](const std::pair<int, int>& count) {
    return StartCount{count.first, count.second};
  });
  return starts;
}

void bindPairs(py::module_& module) {
  module.def("tango_interval", [](const Counts& counts) { return endsOf(tangoInterval(tableOf(counts))); });
  module.def("tang_interval", [](const Counts& counts) { return endsOf(tangInterval(tableOf(counts))); });
  module.def("mcnemar_exact", [](const Counts& counts) { return mcnemarExact(tableOf(counts)); });
  module.def("mcnemar_mid_p", [](const Counts& counts) { return mcnemarMidP(tableOf(counts)); });
  module.def("transfer_sequence", [](const Counts& counts) { return endsOf(transferSequence(tableOf(counts))); });
  module.def("holm", holm);
  module.def("verdict_of", [](double low, double high) { return nameOf(verdictOf({low, high})); });
}

void bindSamples(py::module_& module) {
  module.def("wilson_interval", [](int successes, int trials) { return endsOf(wilsonInterval(successes, trials)); });
  module.def("mean_of", [](const Samples& samples, double limit) { return plain(meanOf(samples, limit)); });
  module.def("median_of", [](const Samples& samples) { return plain(medianOf(samples)); });
  module.def("paired_difference", [](const Samples& differences, const std::optional<double>& extreme) {
    return plain(pairedDifference(differences, extreme));
  });
}

void bindRepeats(py::module_& module) {
  module.def("repeated_rate_interval", [](const std::vector<std::pair<int, int>>& counts) {
    return endsOf(repeatedRateInterval(startsOf(counts)));
  });
  module.def("repeated_difference",
             [](const std::vector<Counts>& starts) { return plain(repeatedDifference(tablesOf(starts))); });
  module.def("repeated_ratio_interval",
             [](const std::vector<Counts>& starts) { return endsOf(repeatedRatioInterval(tablesOf(starts))); });
}

void bindPlanning(py::module_& module) {
  module.def("smallest_difference", smallestDifference);
  module.def("episodes_for", episodesFor);
  module.def("mcnemar_power", mcnemarPower);
  module.def("smallest_rate_difference", smallestRateDifference);
  module.def("episodes_for_rates", episodesForRates);
}

}  // namespace

void bindStatistics(py::module_& module) {
  py::module_ statistics = module.def_submodule("statistics");
  bindPairs(statistics);
  bindSamples(statistics);
  bindRepeats(statistics);
  bindPlanning(statistics);
}

}  // namespace sim2sim::python
