// SPDX-License-Identifier: BSD-3-Clause
#include "network_probes.hpp"

#include <algorithm>

#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"

namespace pusht {

std::vector<Observation> networkProbes() {
  constexpr int kSpawnProbes = 48;
  constexpr double kWideRange = 2.0;  // every number of a wide probe lies in +- this
  std::vector<Observation> probes(kNetworkProbes);
  for (int i = 0; i < kSpawnProbes; ++i) {
    probes[i] = observe(spawn(i));
  }
  NumpyGenerator generator(kSpawnProbes);
  for (int i = kSpawnProbes; i < kNetworkProbes; ++i) {
    std::generate(probes[i].begin(), probes[i].end(), [&] { return generator.uniform(-kWideRange, kWideRange); });
  }
  return probes;
}

}  // namespace pusht
