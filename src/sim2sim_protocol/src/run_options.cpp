// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/run_options.hpp"

namespace sim2sim {

bool operator==(const RunOptions& a, const RunOptions& b) {
  bool equal = true;
  forEachOption([&](const auto& option) { equal = equal && option.of(a) == option.of(b); });
  return equal;
}

}  // namespace sim2sim
