// SPDX-License-Identifier: BSD-3-Clause
/// Simulated episodes whose truth is known: like those of the shipped policy, or drawn from those of a run.
#pragma once

#include <algorithm>
#include <array>
#include <boost/math/constants/constants.hpp>
#include <boost/math/distributions/gamma.hpp>
#include <boost/math/distributions/normal.hpp>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "sim2sim_statistics/common.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/pairs.hpp"

namespace sim2sim {

using Random = std::mt19937_64;

constexpr double kPi = boost::math::constants::pi<double>();

inline double normal(Random& random) { return std::normal_distribution<double>()(random); }
inline double uniform(Random& random) { return std::uniform_real_distribution<double>()(random); }
inline double normalCdf(double x) { return boost::math::cdf(boost::math::normal(), x); }

/// Population of a quantity, one value for each episode.
struct Population {
  std::string name;
  double mean;
  double median;
  double limit;  ///< of the quantity
  std::function<double(Random&)> draw;
};

/// Population of paired differences of a quantity.
struct Differences {
  std::string name;
  double mean;
  std::function<double(Random&)> draw;
};

/// Population of outcomes of two simulators in one episode.
struct Rates {
  std::string name;
  double both;
  double first_only;
  double second_only;

  double first() const { return both + first_only; }
  double second() const { return both + second_only; }

  /// Whether the first and the second succeed in one more episode.
  std::pair<bool, bool> draw(Random& random) const {
    const double u = uniform(random);
    const bool only_first = u >= both && u < both + first_only;
    const bool only_second = u >= both + first_only && u < both + first_only + second_only;
    return {u < both || only_first, u < both || only_second};
  }

  PairTable draw(int pairs, Random& random) const {
    PairTable table;
    while (table.pairs() < pairs) {
      std::apply([&table](bool first, bool second) { table.add(first, second); }, draw(random));
    }
    return table;
  }
};

/// Lognormal with that mean and median, cut off at `limit`: angles cannot exceed pi.
struct Lognormal {
  double mean;
  double median;
  double limit = std::numeric_limits<double>::infinity();
  double sigma = edge([this](double s) { return meanOf(s) <= mean; }, 0.01, 3.0);

  /// Mean of the cut-off distribution with that sigma.
  double meanOf(double s) const {
    const double mu = std::log(median);
    const double beyond = (std::log(limit) - mu) / s;  // [sigma]
    const double cut = std::isinf(limit) ? 0.0 : limit * (1.0 - normalCdf(beyond));
    return std::exp(mu + 0.5 * s * s) * (std::isinf(limit) ? 1.0 : normalCdf(beyond - s)) + cut;
  }
  double at(double z) const { return std::min(limit, median * std::exp(sigma * z)); }
};

inline Population lognormal(const std::string& name, const Lognormal& distribution) {
  return {name, distribution.mean, distribution.median, distribution.limit,
          [distribution](Random& random) { return distribution.at(normal(random)); }};
}

/// Share of episodes in which neither tee moves.
constexpr double kStill = 0.0473;

/// Gamma with that mean and median, zeros included.
inline Population gammaWithZeros(const std::string& name, double mean, double median) {
  const double mean_of_others = mean / (1.0 - kStill);
  const auto below_median = [&](double shape) {
    return boost::math::cdf(boost::math::gamma_distribution(shape, mean_of_others / shape), median);
  };
  // The larger the shape, the fewer lie below a median that is below the mean.
  const double shape = edge([&](double s) { return below_median(s) >= (0.5 - kStill) / (1.0 - kStill); }, 1.0, 50.0);
  return {name, mean, median, std::numeric_limits<double>::infinity(), [=](Random& random) {
            return uniform(random) < kStill ? 0.0
                                            : std::gamma_distribution<double>(shape, mean_of_others / shape)(random);
          }};
}

/// a - b, with that correlation of the logarithms; zero where nothing moves.
inline Differences difference(const std::string& name, const Lognormal& a, const Lognormal& b, double correlation) {
  return {name, (1.0 - kStill) * (a.mean - b.mean), [=](Random& random) {
            const bool moves = uniform(random) >= kStill;
            const double z = normal(random);
            const double other = correlation * z + std::sqrt(1.0 - correlation * correlation) * normal(random);
            return moves ? a.at(z) - b.at(other) : 0.0;
          }};
}

/// Populations to simulate: like the shipped policy's 10 000 episodes, and like those of a file.
struct World {
  std::vector<Population> populations;
  std::vector<Differences> differences;
  std::vector<Rates> rates;
};

inline const Lognormal kPosition = {0.079, 0.0697};       // [m]
inline const Lognormal kPositionAt20 = {0.0734, 0.0646};  // [m]
inline const Lognormal kAngle = {0.97, 0.84, kPi};        // [rad]
inline const Lognormal kNullAngle = {0.945, 0.848, kPi};  // [rad] of a tee that never moves

inline World shippedPolicy() {
  return {{lognormal("position, lognormal", kPosition), gammaWithZeros("position, gamma and zeros", 0.079, 0.0697),
           lognormal("angle, saturating", kAngle)},
          {difference("position, 20 against 6", kPositionAt20, kPosition, 0.73),
           difference("angle, 6 against the null model", kAngle, kNullAngle, 0.3)},
          {{"block_damp 2", 0.0308, 0.5817, 0.0148},
           {"block_damp 6", 0.1240, 0.4885, 0.0661},
           {"block_damp 20", 0.1048, 0.5077, 0.0504},
           {"block_damp 60", 0.0737, 0.5388, 0.0298},
           {"20 against 6", 0.0376, 0.1525, 0.1175}}};
}

/// Whose episodes are drawn with replacement.
inline Population resampled(const std::string& name, std::vector<double> samples, double limit) {
  std::sort(samples.begin(), samples.end());
  return {name, averageOf(samples), quantileOf(samples, 0.5), limit, [samples](Random& random) {
            return samples[static_cast<std::size_t>(uniform(random) * static_cast<double>(samples.size()))];
          }};
}

/// The lines of an episodes.csv by column.
inline std::vector<std::map<std::string, std::string>> readCsv(const std::string& path) {
  std::ifstream file(path);
  const auto cells = [](const std::string& line) {
    std::vector<std::string> result;
    std::istringstream text(line + ",");
    for (std::string cell; std::getline(text, cell, ',');) {
      result.push_back(cell);
    }
    return result;
  };
  std::string line;
  if (!std::getline(file, line)) {
    throw std::domain_error("episodes " + path + ": must be a readable episodes.csv");
  }
  const std::vector<std::string> columns = cells(line);
  std::vector<std::map<std::string, std::string>> lines;
  while (std::getline(file, line)) {
    const std::vector<std::string> values = cells(line);
    lines.emplace_back();
    for (std::size_t i = 0; i < std::min(columns.size(), values.size()); ++i) {
      lines.back()[columns[i]] = values[i];
    }
  }
  return lines;
}

/// Adds what the episodes of a run say.
inline void addFile(const std::string& path, World& world) {
  std::vector<double> positions;
  std::vector<double> angles;
  std::map<std::string, std::array<bool, 2>> successes;  // of reference and engine, by episode
  for (auto& line : readCsv(path)) {
    const auto number = [&](const char* column) {
      const std::string& text = line[column];
      double value = 0.0;
      const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
      if (read.ec != std::errc() || read.ptr != text.data() + text.size() || !std::isfinite(value)) {
        throw std::domain_error("episodes " + path + ", " + column + " '" + text + "': must be a number");
      }
      return value;
    };
    if (line["mode"] == "engine_replay") {
      positions.push_back(number("mean_position_divergence_m"));
      angles.push_back(number("mean_angle_divergence_rad"));
    } else if (line["mode"] == "reference_closed") {
      successes[line["episode"]][0] = line["success"] == "true";
    } else if (line["mode"] == "engine_closed") {
      successes[line["episode"]][1] = line["success"] == "true";
    }
  }
  if (positions.empty()) {
    throw std::domain_error("episodes " + path + ": must have lines of the mode engine_replay");
  }
  PairTable table;
  for (const auto& [episode, success] : successes) {
    table.add(success[0], success[1]);
  }
  const double n = table.pairs();
  world.populations.push_back(resampled("position, the file", positions, std::numeric_limits<double>::infinity()));
  world.populations.push_back(resampled("angle, the file", angles, kPi));
  world.rates.push_back({"the file", table.both / n, table.first_only / n, table.second_only / n});
}

}  // namespace sim2sim
