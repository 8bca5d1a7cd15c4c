// SPDX-License-Identifier: BSD-3-Clause
#include "network_probes.hpp"

#include <algorithm>

#include "pusht_task/gym_pusht.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"

namespace pusht {

std::vector<Observation> networkProbes(const PolicyInterface& interface) {
  constexpr int kSpawnProbes = 48;
  constexpr double kWideRange = 2.0;  // [m, -] every number of a wide probe lies in +- this
  const bool is_gyms = interface.name != PolicyInterface::Name::kFullCircle;
  const Task& task = is_gyms ? gymPusht() : fullCircle();
  std::vector<Observation> probes(kNetworkProbes);
  for (int i = 0; i < kSpawnProbes; ++i) {
    probes[i] = observe(spawn(i, task), task);
  }
  NumpyGenerator generator(kSpawnProbes);
  for (int i = kSpawnProbes; i < kNetworkProbes; ++i) {
    std::generate(probes[i].begin(), probes[i].end(), [&] { return generator.uniform(-kWideRange, kWideRange); });
    if (is_gyms) {  // a position each, in pixels
      for (const std::size_t position : {0U, 1U, 2U, 3U, 6U, 7U}) {
        probes[i][position] *= static_cast<float>(gym_pusht::kSide);
      }
    }
  }
  return probes;
}

}  // namespace pusht
