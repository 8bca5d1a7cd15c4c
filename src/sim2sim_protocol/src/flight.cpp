// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/flight.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "pusht_task/error.hpp"

namespace sim2sim {
namespace {

void requireFinite(const pusht::Action& action) {
  if (!pusht::isFinite(action)) {
    throw pusht::BadDependency("the policy's action (" + std::to_string(action[0]) + ", " + std::to_string(action[1]) +
                               ") must be finite");
  }
}

/// Runs `action`; an error of it then says where in the episode it came up.
template <class Function>
auto located(const Protocol& protocol, int episode, std::string_view mode, const int& step, const Function& action) {
  try {
    return action();
  } catch (pusht::Error& error) {
    error.addContext("episode " + std::to_string(episode) + " (" +
                     (protocol.initial_states ? "start " : "spawn seed ") + protocol.initialStateKey(episode) + "), " +
                     std::string(mode) + ", step " + std::to_string(step));
    throw;
  }
}

/// Resets a lane of `world` to the initial state of an episode, which a probe moves by `tee_offset` [m].
void place(const Protocol& protocol, int episode, pusht::BatchSimulator& world, int lane, double tee_offset = 0.0) {
  if (const auto seed = protocol.spawnSeed(episode); seed && tee_offset == 0.0) {
    world.spawn(lane, *seed);
    return;
  }
  pusht::WorldState start = protocol.initialState(episode);
  start.tee_position.x() += tee_offset;
  world.reset(lane, start);
}

/// Query of a rollout in a lane of `world`.
pusht::Policy::Query queryOf(const pusht::Rollout& rollout, const pusht::BatchSimulator& world, int lane) {
  pusht::Policy::Query query = rollout.query();
  query.state_in_pixels = world.stateInPixels(lane);
  return query;
}

}  // namespace

Worlds worldsOf(std::unique_ptr<pusht::Simulator> reference, std::unique_ptr<pusht::Simulator> engine,
                std::unique_ptr<pusht::Simulator> replay) {
  return {std::make_unique<pusht::SimulatorLanes>(std::move(reference)),
          std::make_unique<pusht::SimulatorLanes>(std::move(engine)),
          std::make_unique<pusht::SimulatorLanes>(std::move(replay))};
}

Flight::Flight(Protocol protocol, const Worlds& worlds, pusht::Policy& policy, const VariantWorlds& variants)
    : protocol_(std::move(protocol)),
      worlds_(worlds),
      policy_(policy),
      variants_(variants),
      episodes_(worlds[protocol_.alone ? kReferenceClosed : kEngineClosed]->lanes()) {}

bool Flight::full() const {
  return std::all_of(episodes_.begin(), episodes_.end(), [](const auto& episode) { return episode.has_value(); });
}

bool Flight::empty() const {
  return std::none_of(episodes_.begin(), episodes_.end(), [](const auto& episode) { return episode.has_value(); });
}

const Episode& Flight::begin(int index, CachedTraces cached) {
  const auto free = std::find(episodes_.begin(), episodes_.end(), std::nullopt);
  const auto lane = static_cast<std::size_t>(free - episodes_.begin());
  pusht::Rollout reference =
      cached.reference
          ? pusht::Rollout(*cached.reference, protocol_.runTask())
          : start(kReferenceClosed, lane, index, policy_.begin(protocol_.beginning(index, pusht::Role::kReference)));
  pusht::Rollout engine =
      start(kEngineClosed, lane, index, policy_.begin(protocol_.beginning(index, pusht::Role::kEngine)));
  pusht::Rollout replay = replaysAfterwards()
                              ? pusht::Rollout(engine.trace().states.front(), nullptr, protocol_.runTask())
                              : start(kEngineReplay, lane, index, nullptr);
  return episodes_.at(lane).emplace(
      protocol_, index,
      std::array<pusht::Rollout, kModeCount>{std::move(reference), std::move(engine), std::move(replay)},
      std::move(cached.probes));
}

pusht::Rollout Flight::start(Mode mode, std::size_t lane, int index, std::unique_ptr<pusht::Policy::Memory> memory) {
  if (!protocol_.isFlown(mode)) {
    return pusht::Rollout(protocol_.initialState(index), nullptr, protocol_.runTask());
  }
  return located(protocol_, index, modeName(mode), 0, [&] {
    pusht::BatchSimulator& world = worldOf(mode);
    place(protocol_, index, world, static_cast<int>(lane));
    return pusht::Rollout(world.state(static_cast<int>(lane)), std::move(memory), protocol_.runTask());
  });
}

pusht::BatchSimulator& Flight::worldOf(Mode mode) const {
  return *worlds_[mode == kEngineReplay && replaysAfterwards() ? kEngineClosed : mode];
}

/// Whether a mode takes the next step: a replay that has no world of its own waits for the closed loop's end.
bool Flight::mayAdvance(Mode mode, std::size_t lane) const {
  const bool waits = mode == kEngineReplay && replaysAfterwards() && goesOn(kEngineClosed, lane);
  return goesOn(mode, lane) && !waits;
}

/// Gives the world of the closed loop to a replay that begins and has none of its own. Throws SimulationFault if it
/// does not start as it did before.
void Flight::turnToReplay(std::size_t lane) {
  const Episode& episode = *episodes_[lane];
  if (!replaysAfterwards() || episode.rollout(kEngineReplay).steps() > 0) {
    return;
  }
  located(protocol_, episode.index(), modeName(kEngineReplay), 0, [&] {
    pusht::BatchSimulator& world = worldOf(kEngineReplay);
    place(protocol_, episode.index(), world, static_cast<int>(lane));
    if (!(world.state(static_cast<int>(lane)) == episode.rollout(kEngineReplay).trace().states.front())) {
      throw pusht::SimulationFault("the second reset to the same state leads to another: must lead to the same bits");
    }
  });
}

void Flight::advance() {
  askPolicy();
  std::size_t next_answer = 0;
  for (const Mode mode : kModes) {  // the replay follows the reference
    advance(mode, next_answer);
  }
}

void Flight::askPolicy() {
  queries_.clear();
  for (const Mode mode : {kReferenceClosed, kEngineClosed}) {
    for (std::size_t lane = 0; lane < episodes_.size(); ++lane) {
      if (goesOn(mode, lane)) {
        queries_.push_back(queryOf(episodes_[lane]->rollout(mode), worldOf(mode), static_cast<int>(lane)));
      }
    }
  }
  answers_.resize(queries_.size());
  if (!queries_.empty()) {
    policy_.act(queries_, answers_);
  }
}

void Flight::advance(Mode mode, std::size_t& next_answer) {
  actions_.assign(episodes_.size(), std::nullopt);
  bool any = false;
  for (std::size_t lane = 0; lane < episodes_.size(); ++lane) {
    if (!mayAdvance(mode, lane)) {
      continue;
    }
    const Episode& episode = *episodes_[lane];
    if (mode == kEngineReplay) {
      turnToReplay(lane);
    }
    const pusht::Action& action = mode == kEngineReplay ? episode.nextReplayed() : answers_.at(next_answer++);
    located(protocol_, episode.index(), modeName(mode), episode.rollout(mode).steps(), [&] { requireFinite(action); });
    actions_[lane] = action;
    any = true;
  }
  if (!any) {
    return;
  }
  pusht::BatchSimulator& world = worldOf(mode);
  world.step(actions_);
  for (std::size_t lane = 0; lane < episodes_.size(); ++lane) {
    if (actions_[lane]) {
      Episode& episode = *episodes_[lane];
      located(protocol_, episode.index(), modeName(mode), episode.rollout(mode).steps(),
              [&] { episode.record(mode, *actions_[lane], world.state(static_cast<int>(lane))); });
    }
  }
}

std::vector<Episode> Flight::land(const std::function<void()>& watch) {
  std::vector<Episode> landed;
  for (std::size_t lane = 0; lane < episodes_.size(); ++lane) {
    if (episodes_[lane] && episodes_[lane]->finished()) {
      probe(*episodes_[lane], lane, watch);
      landed.push_back(std::move(*episodes_[lane]));
      episodes_[lane].reset();
    }
  }
  return landed;
}

void Flight::probe(Episode& episode, std::size_t lane, const std::function<void()>& watch) const {
  const int index = episode.index();
  const std::vector<Probe> probes = protocol_.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    if (episode.probe(i)) {
      continue;
    }
    const Probe& probe = probes[i];
    const bool in_variant = probe.world == ProbedWorld::kVariant;
    pusht::BatchSimulator& world =
        in_variant ? variantOf(probe) : worldOf(probe.isOfReference() ? kReferenceClosed : kEngineReplay);
    int step = 0;
    const auto before_step = [&](int next) {
      step = next;
      watch();
    };
    located(protocol_, index, probe.name, step, [&] {
      const std::size_t in_lane = in_variant ? 0 : lane;
      place(protocol_, index, world, static_cast<int>(in_lane), probe.tee_offset);
      const pusht::Trace& reference = episode.rollout(kReferenceClosed).trace();
      episode.recordProbe(
          i, probe.closed ? drive(world, index, before_step) : runProbe(probe, reference, world, in_lane, before_step));
    });
  }
}

pusht::BatchSimulator& Flight::variantOf(const Probe& probe) const {
  const std::vector<std::string> names = variantsOf(protocol_);
  return *variants_.at(static_cast<std::size_t>(std::find(names.begin(), names.end(), probe.variant) - names.begin()));
}

/// Lets the policy drive the only lane of a model variant, which has been reset.
pusht::Trace Flight::drive(pusht::BatchSimulator& world, int index, const std::function<void(int)>& before_step) const {
  pusht::Rollout rollout(world.state(0), policy_.begin(protocol_.beginning(index, pusht::Role::kReference)),
                         protocol_.runTask());
  while (!rollout.finished(protocol_.horizon)) {
    before_step(rollout.steps());
    const std::array<pusht::Policy::Query, 1> query = {queryOf(rollout, world, 0)};
    std::array<pusht::Action, 1> action{};
    policy_.act(query, action);
    requireFinite(action.front());
    world.step(std::array<std::optional<pusht::Action>, 1>{action.front()});
    rollout.record(action.front(), world.state(0));
  }
  return rollout.trace();
}

Episode runEpisode(const Protocol& protocol, int index, const Worlds& worlds, pusht::Policy& policy,
                   CachedTraces cached) {
  const VariantWorlds none;
  Flight flight(protocol, worlds, policy, none);
  flight.begin(index, std::move(cached));
  std::vector<Episode> landed = flight.land();
  while (landed.empty()) {
    flight.advance();
    landed = flight.land();
  }
  return std::move(landed.front());
}

}  // namespace sim2sim
