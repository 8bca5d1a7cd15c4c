// SPDX-License-Identifier: BSD-3-Clause
// A control step allocates nothing, in any world, in the policy, in the protocol's own bookkeeping.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "pusht_engine/rigid_body_engine.hpp"
#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/scenarios.hpp"
#include "sim2sim_eval/batch/loaded_run.hpp"
#include "sim2sim_protocol/flight.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/runner.hpp"

namespace {

std::atomic<bool> counting = false;
std::atomic<int> allocations = 0;

/// The function that ours hides.
template <class Function>
Function* hidden(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

void note() {
  if (counting) {
    ++allocations;
  }
}

}  // namespace

// Ours come before those of the C library in every library of the process; operator new ends in them too.
extern "C" {
void* malloc(std::size_t size) {
  static auto* const next = hidden<void*(std::size_t)>("malloc");
  note();
  return next(size);
}
void* calloc(std::size_t count, std::size_t size) {
  // dlsym itself may ask for memory here, before the hidden function is known: that comes from the stock.
  static thread_local bool asking = false;
  if (asking) {
    return nullptr;
  }
  asking = true;
  static auto* const next = hidden<void*(std::size_t, std::size_t)>("calloc");
  asking = false;
  note();
  return next(count, size);
}
void* realloc(void* memory, std::size_t size) {
  static auto* const next = hidden<void*(void*, std::size_t)>("realloc");
  note();
  return next(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  static auto* const next = hidden<void*(std::size_t, std::size_t)>("aligned_alloc");
  note();
  return next(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  static auto* const next = hidden<int(void**, std::size_t, std::size_t)>("posix_memalign");
  note();
  return next(memory, alignment, size);
}
}

namespace sim2sim {
namespace {

constexpr int kWarmUp = 10;
constexpr int kSteps = 100;

/// Allocations of `kSteps` calls after some to warm up.
template <class Function>
int allocationsOf(const Function& step) {
  for (int i = 0; i < kWarmUp; ++i) {
    step();
  }
  allocations = 0;
  counting = true;
  for (int i = 0; i < kSteps; ++i) {
    step();
  }
  counting = false;
  return allocations;
}

WorkerFactory workersOf(const std::string& policy) {
  const sim2sim::SimulatorChoice engine = sim2sim::chooseSimulator("two_mass", {});
  return sim2sim::LoadedRun({policy}, sim2sim::chooseSimulator("mujoco", {}), {engine}, {})
      .workerFactory(sim2sim::LoadedSimulator(engine));
}

TEST(Allocations, AreCounted) {
  int* volatile number = nullptr;  // volatile, or the compiler would leave the pair out
  EXPECT_EQ(allocationsOf([&] {
              number = new int(1);  // NOLINT(cppcoreguidelines-owning-memory)
              delete number;        // NOLINT(cppcoreguidelines-owning-memory)
            }),
            kSteps);
  EXPECT_EQ(allocationsOf([] { mju_free(mju_malloc(8)); }), kSteps) << "those of MuJoCo too";
}

/// While it chases the tee, so that there is contact.
int allocationsOfChase(pusht::Simulator& world) {
  pusht::Rollout rollout = pusht::begin(world, pusht::spawn(3));
  return allocationsOf([&] { pusht::advance(rollout, world, pusht::testing::chase(world.state())); });
}

TEST(Allocations, NoneInAStepOfASimulator) {
  pusht::TwoMassEngine engine;
  EXPECT_EQ(allocationsOfChase(engine), 0);
  pusht::RigidBodyEngine rigid;
  EXPECT_EQ(allocationsOfChase(rigid), 0);
  pusht::MujocoWorld mujoco(std::make_shared<const pusht::MujocoScene>());
  EXPECT_EQ(allocationsOfChase(mujoco), 0);
}

TEST(Allocations, NoneInAStepOfTheWholeProtocol) {
  const Protocol protocol;
  for (const char* policy_name : {"bc", "expert"}) {
    const WorkerFactory workers = workersOf(policy_name);
    const Worlds worlds = workers.make_worlds(kEpisodesInFlight);
    const auto policy = workers.make_policy();
    const sim2sim::VariantWorlds none;
    Flight flight(protocol, worlds, *policy, none);
    for (int index = 0; index < kEpisodesInFlight; ++index) {
      flight.begin(index);
    }
    EXPECT_EQ(allocationsOf([&] { flight.advance(); }), 0) << policy_name;
    EXPECT_TRUE(flight.land().empty()) << "all were under way all the time";
  }
}

}  // namespace
}  // namespace sim2sim
