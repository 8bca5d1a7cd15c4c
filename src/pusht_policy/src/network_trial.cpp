// SPDX-License-Identifier: BSD-3-Clause
#include "network_trial.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cmath>

#include "network_memory.hpp"
#include "network_probes.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"

namespace pusht {
namespace {

constexpr float kAgreement = 1e-5F;  // between kernel and libtorch; relative where actions exceed 1

constexpr int kCallsWithState = 4;  // one after the other, each with the state of the one before

/// Histories for each probe, one after the other: at the beginning of a rollout, where one observation is repeated, and
/// every second one of unlike observations.
std::vector<float> probeHistories(int observations) {
  const std::vector<Observation> all = networkProbes();
  std::vector<float> histories;
  for (int probe = 0; probe < kNetworkProbes; ++probe) {
    for (int i = 0; i < observations; ++i) {
      const Observation& observation = all[(probe + i * (probe % 2)) % kNetworkProbes];
      histories.insert(histories.end(), observation.begin(), observation.end());
    }
  }
  return histories;
}

/// Throws BadDependency unless all numbers of an answer, or of a state, are finite.
void requireFinite(const std::vector<float>& values, const std::string& what, int numbers_of_one, int probe,
                   const std::string& name) {
  const auto bad = std::find_if(values.begin(), values.end(), [](float value) { return !std::isfinite(value); });
  if (bad != values.end()) {
    throw BadDependency(name + ": its " + what + "s must be finite, but " + what + " " +
                        std::to_string((bad - values.begin()) / numbers_of_one + 1) + " of " +
                        std::to_string(values.size() / numbers_of_one) + " is " + shortestText(*bad) + " for probe " +
                        std::to_string(probe));
  }
}

std::vector<float> answersTo(const std::vector<float>& histories, TorchNetwork& network, const std::string& name) {
  constexpr int kActionNumbers = std::tuple_size<Action>::value;
  const PolicyDescription& description = network.description();
  const bool has_state = !description.state.empty();
  const int stride = has_state || description.isStochastic() ? kCallsWithState : 1;  // as many calls for all networks
  const std::size_t length = histories.size() / kNetworkProbes;
  std::vector<float> answers;
  std::vector<float> answer(static_cast<std::size_t>(description.actions) * kActionNumbers);
  std::vector<float> noise(numbersIn(description.noise));
  for (int probe = 0; probe < kNetworkProbes; probe += stride) {
    std::vector<float> state(numbersIn(description.state));
    PolicyNoise generator(static_cast<std::uint64_t>(probe), description.distribution);
    for (int call = 0; call < stride; ++call) {
      generator.draw(noise);
      network.run({histories.data() + (probe + call) * length, length}, state, noise, answer);
      requireFinite(answer, "action", kActionNumbers, probe + call, name);
      requireFinite(state, "state number", 1, probe + call, name);
      answers.insert(answers.end(), answer.begin(), answer.end());
    }
  }
  return answers;
}

/// Throws RuntimeFault unless there is memory for the buffers of OpenBLAS, of one of its threads and of the caller's:
/// it asks for them in an endless loop.
void requireMemoryOfBlas(const std::string& name) {
  constexpr std::size_t kBuffers = std::size_t{2} << 27U;  // bytes, as Debian builds it
  void* const buffers = mmap(nullptr, kBuffers, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (buffers == MAP_FAILED) {
    throw RuntimeFault(name + ": its matrices need " + std::to_string(kBuffers >> 20U) +
                       " MB more of memory for the BLAS");
  }
  munmap(buffers, kBuffers);
}

}  // namespace

std::vector<float> tryOut(TorchNetwork& network, const std::string& name) {
  requireMemoryOfBlas(name);
  const std::vector<float> histories = probeHistories(network.description().observations);
  std::vector<float> answers = answersTo(histories, network, name);
  if (answersTo(histories, network, name) != answers) {
    throw BadDependency(name +
                        ": must act the same on the same inputs, but has a memory or is random: it must take its state "
                        "and its noise as inputs, and say so in its policy.json");
  }
  return answers;
}

void requireAgreement(NetworkKernel& kernel, const PolicyDescription& description, const std::vector<float>& expected) {
  const std::vector<float> histories = probeHistories(description.observations);
  std::vector<float> actual(expected.size());
  kernel.run(histories, actual);
  for (std::size_t i = 0; i < actual.size(); ++i) {
    const float difference = std::abs(actual[i] - expected[i]);
    if (!(difference <= kAgreement * std::max(1.0F, std::abs(expected[i])))) {
      throw UnfitForKernel("the kernel differs from libtorch by " + std::to_string(difference) + " for probe " +
                           std::to_string(i * kNetworkProbes / actual.size()));
    }
  }
}

}  // namespace pusht
