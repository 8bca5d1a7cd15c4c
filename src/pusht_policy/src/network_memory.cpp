// SPDX-License-Identifier: BSD-3-Clause
#include "network_memory.hpp"

#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_real_distribution.hpp>

namespace pusht {
namespace {

constexpr std::size_t kActionNumbers = std::tuple_size<Action>::value;

}  // namespace

PolicyNoise::PolicyNoise(std::uint64_t seed, PolicyDescription::Distribution distribution)
    : generator_(seed, "policy noise"), distribution_(distribution) {}

void PolicyNoise::draw(Span<float> noise) {
  if (distribution_ == PolicyDescription::Distribution::kNormal) {
    boost::random::normal_distribution<double> normal;
    std::generate(noise.begin(), noise.end(), [&] { return static_cast<float>(normal(generator_.bits())); });
  } else {
    boost::random::uniform_real_distribution<float> uniform;  // in float, or a double below 1 would round to 1
    std::generate(noise.begin(), noise.end(), [&] { return uniform(generator_.bits()); });
  }
}

NetworkMemory::NetworkMemory(const PolicyDescription& description, const Beginning& beginning)
    : interface_(description.interface),
      history_(static_cast<std::size_t>(description.observations) *
               static_cast<std::size_t>(description.interface.numbers())),
      state_(numbersIn(description.state)),
      answer_(static_cast<std::size_t>(description.actions) * kActionNumbers),
      execute_(beginning.execute > 0 ? beginning.execute : description.execute),
      next_(execute_) {
  if (description.isStochastic()) {
    noise_.emplace(beginning.seed, description.distribution);
  }
}

void NetworkMemory::see(const Observation& observation) {
  const auto numbers = static_cast<std::ptrdiff_t>(interface_.numbers());
  if (begun_) {
    std::move(history_.begin() + numbers, history_.end(), history_.begin());
  }
  const auto latest = history_.end() - numbers;
  interface_.look(observation, {&*latest, static_cast<std::size_t>(numbers)});
  for (auto place = history_.begin(); !begun_ && place != latest; place += numbers) {
    std::copy(latest, history_.end(), place);
  }
  begun_ = true;
}

void NetworkMemory::draw(Span<float> noise) {
  if (noise_) {
    noise_->draw(noise);
  }
}

Span<float> NetworkMemory::answer() {
  next_ = 0;
  return answer_;
}

Action NetworkMemory::next() {
  Action action{};
  std::copy_n(answer_.begin() + static_cast<std::ptrdiff_t>(next_ * kActionNumbers), kActionNumbers, action.begin());
  ++next_;
  return action;
}

}  // namespace pusht
