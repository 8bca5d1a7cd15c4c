// SPDX-License-Identifier: BSD-3-Clause
/// Tables of the command `coverage`, in Markdown.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <functional>
#include <iostream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/sequential.hpp"
#include "simulation.hpp"

namespace sim2sim {

/// `value` as text, in that format of std::to_chars with so many digits; independent of the locale.
inline std::string textOf(double value, std::chars_format format, int digits) {
  std::array<char, 512> buffer{};  // the longest double in fixed notation has 309 digits before the point
  return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, format, digits).ptr};
}
/// `value` with `digits` digits after the point: 0.082000.
inline std::string fixedText(double value, int digits) { return textOf(value, std::chars_format::fixed, digits); }
/// `value` with the first `digits` digits that count, as C's %g writes it: 0.0123, 1.23e-09.
inline std::string significantText(double value, int digits) {
  return textOf(value, std::chars_format::general, digits);
}

/// Which side of the nominal share is to be marked: `kWorse` is all for a test that promises no more than a bound.
enum class Marks { kBoth, kWorse };

/// Share in percent, with its standard error. Bold if it is worse than nominal by more than two standard errors, in
/// brackets if it is better.
inline std::string cell(const Proportion& share, double nominal, bool more_is_worse, Marks marks) {
  if (share.all == 0) {
    return "none";
  }
  const std::string text =
      fixedText(100.0 * share.value(), 1) + " ± " + fixedText(100.0 * share.error(share.value()), 1);
  const double deviation = (share.value() - nominal) / share.error(nominal) * (more_is_worse ? 1.0 : -1.0);
  if (deviation > 2.0) {
    return "**" + text + "**";
  }
  return deviation < -2.0 && marks == Marks::kBoth ? "(" + text + ")" : text;
}

inline std::string coverageCell(const Proportion& share) { return cell(share, kConfidence, false, Marks::kBoth); }
inline std::string errorCell(const Proportion& share) { return cell(share, kErrorRate, true, Marks::kBoth); }
inline std::string boundCell(const Proportion& share) { return cell(share, kErrorRate, true, Marks::kWorse); }

inline void printRow(const std::vector<std::string>& cells) {
  std::cout << "|";
  for (const std::string& text : cells) {
    std::cout << " " << text << " |";
  }
  std::cout << "\n" << std::flush;
}

inline void printHead(const std::string& title, std::vector<std::string> columns) {
  std::cout << "\n" << title << "\n\n";
  printRow(columns);
  std::fill(columns.begin(), columns.end(), "---");
  printRow(columns);
}

inline std::vector<std::string> withSizes(const std::vector<int>& sizes, std::vector<std::string> columns) {
  for (const int n : sizes) {
    columns.push_back("n = " + std::to_string(n));
  }
  return columns;
}

/// A row with a cell for each number of episodes.
inline void printSizes(const std::vector<int>& sizes, const std::string& what, const std::string& of,
                       const std::function<std::string(int)>& cell_of) {
  std::vector<std::string> cells = {what, of};
  std::transform(sizes.begin(), sizes.end(), std::back_inserter(cells), cell_of);
  printRow(cells);
}

inline std::optional<bool> holds(const std::optional<Interval>& interval, double truth) {
  return interval ? std::optional(interval->low <= truth && truth <= interval->high) : std::nullopt;
}

/// The interval of so many episodes.
using MakeInterval = std::function<std::optional<Interval>(int, Random&)>;

inline void printCoverage(Simulation& simulation, const std::vector<int>& sizes, const std::string& what,
                          const std::string& of, double truth, const MakeInterval& make) {
  printSizes(sizes, what, of, [&](int n) {
    return coverageCell(simulation.ask([&](Random& random) { return holds(make(n, random), truth); }));
  });
}

}  // namespace sim2sim
