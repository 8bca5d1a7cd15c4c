// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/spawn.hpp"

#include <array>
#include <cmath>
#include <cstddef>

#include "pusht_task/constants.hpp"
#include "pusht_task/contact.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/gym_pusht.hpp"

namespace pusht {
namespace {

/// The two words of an integer, low first.
std::array<std::uint32_t, 2> wordsOf(std::uint64_t value) {
  return {static_cast<std::uint32_t>(value), static_cast<std::uint32_t>(value >> 32U)};
}

/// numpy's SeedSequence for an entropy of at most four words: O'Neill's seed_seq_fe with a pool of four words.
class SeedSequence {
 public:
  SeedSequence(std::uint64_t seed, std::uint64_t purpose) {
    const auto [low, high] = wordsOf(seed);
    const auto [purpose_low, purpose_high] = wordsOf(purpose);
    const std::array<std::uint32_t, kPoolSize> entropy = {low, high, purpose_low, purpose_high};
    Hash hash{0x43b0d7e5U, 0x931e8875U};
    for (std::size_t i = 0; i < kPoolSize; ++i) {
      pool_[i] = hash(entropy[i]);
    }
    for (std::size_t source = 0; source < kPoolSize; ++source) {
      for (std::size_t target = 0; target < kPoolSize; ++target) {
        if (source != target) {
          pool_[target] = mix(pool_[target], hash(pool_[source]));
        }
      }
    }
  }

  /// The first four 64-bit words of the state, each from two 32-bit words, low first.
  std::array<std::uint64_t, 4> generateState() const {
    Hash hash{0x8b51f9ddU, 0x58f38dedU};
    std::array<std::uint64_t, 4> state{};
    for (std::size_t i = 0; i < 2 * state.size(); ++i) {
      const std::uint64_t word = hash(pool_[i % kPoolSize]);
      state[i / 2] |= word << (32U * (i % 2));
    }
    return state;
  }

 private:
  static constexpr std::size_t kPoolSize = 4;

  /// A multiplicative hash whose constant moves on with every call.
  struct Hash {
    std::uint32_t constant;
    std::uint32_t multiplier;
    std::uint32_t operator()(std::uint32_t value) {
      value ^= constant;
      constant *= multiplier;
      value *= constant;
      return value ^ (value >> 16U);
    }
  };

  static std::uint32_t mix(std::uint32_t x, std::uint32_t y) {
    const std::uint32_t result = 0xca01f9ddU * x - 0x4973f715U * y;
    return result ^ (result >> 16U);
  }

  std::array<std::uint32_t, kPoolSize> pool_{};
};

pcg64 seededEngine(std::uint64_t seed, std::uint64_t purpose) {
  using pcg_extras::pcg128_t;  // named by the macro
  const auto words = SeedSequence(seed, purpose).generateState();
  return pcg64(PCG_128BIT_CONSTANT(words[0], words[1]), PCG_128BIT_CONSTANT(words[2], words[3]));
}

}  // namespace

NumpyGenerator::NumpyGenerator(std::uint64_t seed) : engine_(seededEngine(seed, 0)) {}

NumpyGenerator::NumpyGenerator(std::uint64_t seed, const std::string& purpose)
    : engine_(seededEngine(seed, std::stoull(md5(purpose).substr(0, 16), nullptr, 16))) {}

double NumpyGenerator::random() { return static_cast<double>(engine_() >> 11U) * 0x1p-53; }

double NumpyGenerator::uniform(double low, double high) { return low + (high - low) * random(); }

std::int32_t NumpyRandomState::randint(std::int32_t low, std::int32_t high) {
  if (low >= high) {
    throw InvalidInput("randint " + std::to_string(low) + ", " + std::to_string(high) +
                       ": the first must be below the second");
  }
  const auto range = static_cast<std::uint32_t>(high) - static_cast<std::uint32_t>(low) - 1U;
  if (range == 0) {
    return low;  // numpy draws nothing
  }
  std::uint32_t mask = range;
  for (const unsigned shift : {1U, 2U, 4U, 8U, 16U}) {
    mask |= mask >> shift;
  }
  std::uint32_t value = 0;
  do {
    value = static_cast<std::uint32_t>(engine_()) & mask;
  } while (value > range);
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(low) + value);
}

double NumpyRandomState::random() {
  const auto high = static_cast<double>(engine_() >> 5U);
  const auto low = static_cast<double>(engine_() >> 6U);
  return (high * 0x1p26 + low) / 0x1p53;
}

double NumpyRandomState::randn() {
  if (spare_) {
    const double spare = *spare_;
    spare_.reset();
    return spare;
  }
  double x = 0.0;
  double y = 0.0;
  double squared = 0.0;
  do {
    x = 2.0 * random() - 1.0;
    y = 2.0 * random() - 1.0;
    squared = x * x + y * y;
  } while (squared >= 1.0 || squared == 0.0);
  const double factor = std::sqrt(-2.0 * std::log(squared) / squared);
  spare_ = factor * x;
  return factor * y;
}

namespace {

/// Draws until `fits`. Throws InvalidInput if that seems never to happen.
template <class Draw, class Fits>
void drawUntil(const Task& task, const char* body, const Draw& draw, const Fits& fits) {
  constexpr int kMostDraws = 10'000;
  for (int i = 0; i < kMostDraws; ++i) {
    draw();
    if (fits()) {
      return;
    }
  }
  throw InvalidInput(std::string("starts of the task ").append(task.name).append(": the ").append(body) +
                     " finds no place in 10000 draws");
}

/// The tee on a ring around the target with any yaw, between the walls; the pusher clear of it.
WorldState onRing(std::uint64_t seed, const Task& task) {
  NumpyGenerator generator(seed);
  const SpawnRing& ring = task.ring;
  WorldState state;
  drawUntil(
      task, "tee",
      [&] {
        const double radius = generator.uniform(ring.least_radius, ring.greatest_radius);
        const double bearing = generator.uniform(0.0, 2.0 * kPi);
        state.tee_position =
            task.target.position + Eigen::Vector2d(radius * std::cos(bearing), radius * std::sin(bearing));
        state.tee_yaw = generator.uniform(-kPi, kPi);
      },
      [&] { return wallGapsOf(state, task).tee > 0.0; });
  const Eigen::Vector2d middle(task.physics.wall_middle[0], task.physics.wall_middle[1]);
  drawUntil(
      task, "pusher",
      [&] {
        state.pusher_position.x() = middle.x() + generator.uniform(-ring.pusher_bound, ring.pusher_bound);
        state.pusher_position.y() = middle.y() + generator.uniform(-ring.pusher_bound, ring.pusher_bound);
      },
      [&] {
        return (state.pusher_position - state.tee_position).norm() > ring.pusher_clearance &&
               !(deepestOverlap(state, task).depth > 0.0);
      });
  return state;
}

}  // namespace

WorldState spawn(std::uint64_t seed, const Task& task) {
  if (seed > task.last_spawn_seed) {
    throw InvalidInput("spawn seed " + std::to_string(seed) + ": must be at most " +
                       std::to_string(task.last_spawn_seed) + " in the task " + task.name);
  }
  switch (task.spawn) {
    case SpawnRule::kRing:
      return onRing(seed, task);
    case SpawnRule::kGymPusht:
      return gym_pusht::toTable(gym_pusht::turned(gym_pusht::drawn(static_cast<std::uint32_t>(seed))));
  }
  throw InternalError("unknown spawn rule");
}

}  // namespace pusht
