// SPDX-License-Identifier: BSD-3-Clause
#include "network_trial.hpp"

#include <algorithm>
#include <cmath>

#include "network_builder.hpp"
#include "network_probes.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"

namespace pusht {
namespace {

constexpr float kAgreement = 1e-5F;  // between kernel and libtorch, of 1 m/s; relative where actions exceed that

constexpr int kCallsWithState = 4;  // one after the other, each with the state of the one before

/// Histories for each probe, one after the other: at the beginning of a rollout, where one observation is repeated, and
/// every second one of unlike observations.
std::vector<float> probeHistories(const PolicyDescription& description) {
  const std::vector<Observation> all = networkProbes(description.interface);
  std::vector<float> seen(static_cast<std::size_t>(description.interface.numbers()));
  std::vector<float> histories;
  for (int probe = 0; probe < kNetworkProbes; ++probe) {
    for (int i = 0; i < description.observations; ++i) {
      description.interface.look(all[(probe + i * (probe % 2)) % kNetworkProbes], seen);
      histories.insert(histories.end(), seen.begin(), seen.end());
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

}  // namespace

std::vector<float> answersToProbes(Network& network, const PolicyDescription& description, const std::string& name) {
  constexpr int kActionNumbers = std::tuple_size<Action>::value;
  const std::vector<float> histories = probeHistories(description);
  const bool has_state = !description.state.empty();
  const int stride = has_state || description.isStochastic() ? kCallsWithState : 1;  // as many calls for all networks
  const std::size_t length = observationNumbers(description);
  std::vector<float> answers;
  std::vector<float> answer(actionNumbers(description));
  std::vector<float> noise(numbersIn(description.noise));
  for (int probe = 0; probe < kNetworkProbes; probe += stride) {
    std::vector<float> state(numbersIn(description.state));
    PolicyNoise generator(static_cast<std::uint64_t>(probe), description.distribution);
    for (int call = 0; call < stride; ++call) {
      generator.draw(noise);
      const NetworkCall one = {{histories.data() + (probe + call) * length, length}, state, noise, answer};
      network.answer({&one, 1});
      requireFinite(answer, "action", kActionNumbers, probe + call, name);
      requireFinite(state, "state number", 1, probe + call, name);
      answers.insert(answers.end(), answer.begin(), answer.end());
    }
  }
  return answers;
}

void requireAgreement(const std::vector<float>& actual, const std::vector<float>& expected,
                      const PolicyInterface& interface) {
  const bool is_gyms = interface.name != PolicyInterface::Name::kFullCircle;
  const auto unit = static_cast<float>(actionPerSpeed(is_gyms ? gymPusht() : fullCircle()));
  for (std::size_t i = 0; i < actual.size(); ++i) {
    const float difference = std::abs(actual[i] - expected[i]);
    if (!(difference <= kAgreement * std::max(unit, std::abs(expected[i])))) {
      throw UnfitForKernel("the kernel differs from libtorch by " + std::to_string(difference) + " for probe " +
                           std::to_string(i * kNetworkProbes / actual.size()));
    }
  }
}

}  // namespace pusht
