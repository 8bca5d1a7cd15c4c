// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <sim2sim_statistics/pairs.hpp>

// Two policies played the same 100 episodes.
int main() {
  const sim2sim::PairTable table = {/*both=*/52, /*first_only=*/9, /*second_only=*/21, /*neither=*/18};
  const auto difference = sim2sim::tangoInterval(table).value();
  const auto ratio = sim2sim::tangInterval(table).value();
  std::printf("new - old: %+.2f [%+.2f, %+.2f], p = %.3f\n", table.difference(), difference.low, difference.high,
              sim2sim::mcnemarMidP(table));
  std::printf("new / old: [%.2f, %.2f]\n", ratio.low, ratio.high);
}
