// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/protocol.hpp"

#include <algorithm>
#include <atomic>
#include <future>
#include <iterator>
#include <limits>
#include <mutex>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/spawn.hpp"
#include "sim2sim_protocol/reference_cache.hpp"
#include "sim2sim_protocol/rest_of_run.hpp"

namespace sim2sim {
namespace {

constexpr int kSmokeEpisodes = 2;
constexpr int kSmokeHorizon = 40;  // [control steps]

/// Refuses an integer that is out of the range of its option.
template <class Option>
void requireWithin(const Option& option, int value) {
  if (value < option.range.least || value > option.range.greatest) {
    throw pusht::InvalidInput(std::string(option.name) + " " + std::to_string(value) + ": must be from " +
                              std::to_string(static_cast<int>(option.range.least)) + " to " +
                              std::to_string(static_cast<int>(option.range.greatest)));
  }
}

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
    error.addContext("episode " + std::to_string(episode) + " (" + (protocol.starts ? "start " : "spawn seed ") +
                     protocol.startName(episode) + "), " + std::string(mode) + ", step " + std::to_string(step));
    throw;
  }
}

/// The name in a reference cache of what the policy does in the reference.
constexpr const char* kKeptReference = "reference";

/// What is kept of an episode.
Recalled recall(const Protocol& protocol, int episode, const ReferenceCache& references) {
  const std::string start = protocol.startName(episode);
  Recalled recalled{references.find(start, kKeptReference), {}};
  for (const Probe& probe : protocol.probes()) {
    recalled.probes.push_back(probe.role == Role::kReference ? references.find(start, probe.name) : std::nullopt);
  }
  return recalled;
}

/// Keeps all of an episode that depends on the reference alone.
void keep(const Protocol& protocol, const Episode& episode, const ReferenceCache& references) {
  const std::string start = protocol.startName(episode.index());
  const std::vector<Probe> probes = protocol.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    if (probes[i].role == Role::kReference) {
      references.keep(start, probes[i].name, episode.probe(i).value());
    }
  }
  references.keep(start, kKeptReference, episode.rollout(kReferenceClosed).trace());
}

RolloutResult resultOf(const Protocol& protocol, std::size_t rollout, const RolloutView& view) {
  RolloutResult result;
  result.steps = view.rollout.steps();
  result.success = view.rollout.success();
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    if (protocol.has(rollout, kQuantities[i].scope)) {
      result.quantities[i] = kQuantities[i].compute(view);
    }
  }
  if (rollout != kReferenceClosed) {
    result.parting = partingOf(view.reference, view.rollout.trace(), protocol.bound());
  }
  return result;
}

}  // namespace

const char* modeName(Mode mode) {
  constexpr std::array<const char*, kModeCount> kNames = {"reference_closed", "engine_closed", "engine_replay"};
  return kNames.at(mode);
}

void Protocol::validate() const {
  forEachOption([&](const auto& option) {
    if constexpr (std::is_same_v<std::decay_t<decltype(option.of(*this))>, int>) {
      requireWithin(option, option.of(*this));
    }
  });
  bound().validate();
  probes();
  if (until_decided && !(*until_decided > 0.0 && *until_decided <= 1.0)) {
    throw pusht::InvalidInput("until_decided " + pusht::shortestText(*until_decided) +
                              ": must be above 0 and at most 1");
  }
  const auto end = static_cast<std::uint64_t>(first_episode) + static_cast<std::uint64_t>(episodes);
  if (seed > std::numeric_limits<std::uint64_t>::max() - pusht::kFirstSpawnSeed - end) {
    throw pusht::InvalidInput("seed " + std::to_string(seed) +
                              ": 10000 + seed + first_episode + episodes must be below 2^64");
  }
}

std::optional<std::uint64_t> Protocol::spawnSeed(int episode) const {
  return starts ? std::nullopt : std::optional(pusht::kFirstSpawnSeed + seed + static_cast<std::uint64_t>(episode));
}

pusht::WorldState Protocol::start(int episode) const {
  return starts ? starts->at(episode) : pusht::spawn(*spawnSeed(episode));
}

std::vector<std::string> Protocol::rolloutNames() const {
  std::vector<std::string> names;
  std::transform(kModes.begin(), kModes.end(), std::back_inserter(names), modeName);
  for (const Probe& probe : probes()) {
    names.push_back(probe.name);
  }
  return names;
}

bool Protocol::has(std::size_t rollout, Scope scope) const {
  const std::optional<Probe> probe =
      rollout < kModeCount ? std::nullopt : std::optional(probes().at(rollout - kModeCount));
  switch (scope) {
    case Scope::kModes:
      return !probe;
    case Scope::kCompared:
      return rollout != kReferenceClosed;
    case Scope::kClosed:
      return rollout == kEngineClosed;
    case Scope::kAnchored:
      return probe && probe->anchor_every > 0;
    case Scope::kFloor:
      return probe && *probe == floorProbes().back();
  }
  return false;
}

std::string Protocol::startName(int episode) const {
  return starts ? starts->nameOf(episode) : std::to_string(*spawnSeed(episode));
}

Protocol smokeRun(Protocol protocol) {
  if (protocol.episodes != Protocol().episodes || protocol.horizon != Protocol().horizon) {
    throw pusht::InvalidInput("episodes " + std::to_string(protocol.episodes) + ", horizon " +
                              std::to_string(protocol.horizon) +
                              ": must be left out for a smoke run, which has its own");
  }
  protocol.episodes = kSmokeEpisodes;
  protocol.horizon = kSmokeHorizon;
  return protocol;
}

Worlds worldsOf(std::unique_ptr<pusht::Simulator> reference, std::unique_ptr<pusht::Simulator> engine,
                std::unique_ptr<pusht::Simulator> replay) {
  return {std::make_unique<pusht::SimulatorLanes>(std::move(reference)),
          std::make_unique<pusht::SimulatorLanes>(std::move(engine)),
          std::make_unique<pusht::SimulatorLanes>(std::move(replay))};
}

Episode::Episode(Protocol protocol, int index, std::array<pusht::Rollout, kModeCount> rollouts,
                 std::vector<std::optional<pusht::Trace>> probes)
    : protocol_(std::move(protocol)), index_(index), rollouts_(std::move(rollouts)), probes_(std::move(probes)) {
  probes_.resize(protocol_.probes().size());
}

int Episode::steps() const {
  return std::max_element(rollouts_.begin(), rollouts_.end(),
                          [](const auto& a, const auto& b) { return a.steps() < b.steps(); })
      ->steps();
}

bool Episode::goesOn(Mode mode) const {
  return mode == kEngineReplay ? rollouts_[kEngineReplay].steps() < rollouts_[kReferenceClosed].steps()
                               : !rollouts_[mode].finished(protocol_.horizon);
}

bool Episode::finished() const {
  return std::none_of(kModes.begin(), kModes.end(), [this](Mode mode) { return goesOn(mode); });
}

const pusht::Action& Episode::nextReplayed() const {
  return rollouts_[kReferenceClosed].trace().actions.at(rollouts_[kEngineReplay].trace().steps());
}

EpisodeResult Episode::result() const {
  EpisodeResult result{index_, protocol_.spawnSeed(index_), {}};
  const pusht::Trace& reference = rollouts_[kReferenceClosed].trace();
  for (const Mode mode : kModes) {
    result.rollouts.push_back(
        resultOf(protocol_, mode, {rollouts_[mode], reference, 0, &rollouts_[kEngineReplay].trace()}));
  }
  const std::vector<Probe> probes = protocol_.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const pusht::Rollout rollout(probes_[i].value());
    const RolloutView view{rollout, reference, probes[i].anchor_every};
    result.rollouts.push_back(resultOf(protocol_, kModeCount + i, view));
  }
  return result;
}

Flight::Flight(Protocol protocol, const Worlds& worlds, pusht::Policy& policy)
    : protocol_(std::move(protocol)), worlds_(worlds), policy_(policy), episodes_(worlds[kEngineClosed]->lanes()) {}

bool Flight::full() const {
  return std::all_of(episodes_.begin(), episodes_.end(), [](const auto& episode) { return episode.has_value(); });
}

bool Flight::empty() const {
  return std::none_of(episodes_.begin(), episodes_.end(), [](const auto& episode) { return episode.has_value(); });
}

const Episode& Flight::begin(int index, Recalled recalled) {
  const auto free = std::find(episodes_.begin(), episodes_.end(), std::nullopt);
  const auto lane = static_cast<std::size_t>(free - episodes_.begin());
  pusht::Rollout reference =
      recalled.reference ? pusht::Rollout(*recalled.reference) : start(kReferenceClosed, lane, index, policy_.begin());
  pusht::Rollout engine = start(kEngineClosed, lane, index, policy_.begin());
  pusht::Rollout replay = start(kEngineReplay, lane, index, nullptr);
  return episodes_.at(lane).emplace(
      protocol_, index,
      std::array<pusht::Rollout, kModeCount>{std::move(reference), std::move(engine), std::move(replay)},
      std::move(recalled.probes));
}

pusht::Rollout Flight::start(Mode mode, std::size_t lane, int index, std::unique_ptr<pusht::Policy::Memory> memory) {
  return located(protocol_, index, modeName(mode), 0, [&] {
    pusht::BatchSimulator& world = *worlds_[mode];
    world.reset(static_cast<int>(lane), protocol_.start(index));
    return pusht::Rollout(world.state(static_cast<int>(lane)), std::move(memory));
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
        queries_.push_back(episodes_[lane]->rollout(mode).query());
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
    if (!goesOn(mode, lane)) {
      continue;
    }
    const Episode& episode = *episodes_[lane];
    const pusht::Action& action = mode == kEngineReplay ? episode.nextReplayed() : answers_.at(next_answer++);
    located(protocol_, episode.index(), modeName(mode), episode.rollout(mode).steps(), [&] { requireFinite(action); });
    actions_[lane] = action;
    any = true;
  }
  if (!any) {
    return;
  }
  worlds_[mode]->step(actions_);
  for (std::size_t lane = 0; lane < episodes_.size(); ++lane) {
    if (actions_[lane]) {
      Episode& episode = *episodes_[lane];
      located(protocol_, episode.index(), modeName(mode), episode.rollout(mode).steps(),
              [&] { episode.record(mode, *actions_[lane], worlds_[mode]->state(static_cast<int>(lane))); });
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
    pusht::BatchSimulator& world = *worlds_[probe.role == Role::kReference ? kReferenceClosed : kEngineReplay];
    int step = 0;
    const auto before_step = [&](int next) {
      step = next;
      watch();
    };
    located(protocol_, index, probe.name, step, [&] {
      const pusht::Trace& reference = episode.rollout(kReferenceClosed).trace();
      episode.recordProbe(i, runProbe(probe, protocol_.start(index), reference, world, lane, before_step));
    });
  }
}

Episode runEpisode(const Protocol& protocol, int index, const Worlds& worlds, pusht::Policy& policy,
                   Recalled recalled) {
  Flight flight(protocol, worlds, policy);
  flight.begin(index, std::move(recalled));
  std::vector<Episode> landed = flight.land();
  while (landed.empty()) {
    flight.advance();
    landed = flight.land();
  }
  return std::move(landed.front());
}

void runProtocol(const Protocol& protocol, const Players& players, int threads, const ReferenceCache* references,
                 const std::function<void(Episode&&)>& deliver, const std::function<bool()>& stop) {
  runRest(protocol, {}, players, threads, references, deliver, stop);
}

void runRest(const Protocol& protocol, const std::set<int>& finished, const Players& players, int threads,
             const ReferenceCache* references, const std::function<void(Episode&&)>& deliver,
             const std::function<bool()>& stop) {
  protocol.validate();
  threads = std::min(threads, protocol.episodes);
  const int in_flight = std::min(kEpisodesInFlight, (protocol.episodes + threads - 1) / threads);
  std::atomic<int> next_episode = protocol.first_episode;
  std::atomic<bool> failed = false;
  std::mutex delivery;

  const auto begin = [&](Flight& flight, int index) {
    flight.begin(index, references != nullptr ? recall(protocol, index, *references) : Recalled());
  };
  const auto finish = [&](Episode&& episode) {
    if (references != nullptr) {
      keep(protocol, episode, *references);
    }
    const std::lock_guard<std::mutex> one_at_a_time(delivery);
    deliver(std::move(episode));
  };
  const auto work = [&] {
    if (next_episode > protocol.lastEpisode()) {
      return;  // others have begun them all
    }
    const Worlds worlds = players.make_worlds(in_flight);
    const auto policy = players.make_policy();
    Flight flight(protocol, worlds, *policy);
    while (!stop() && !failed) {
      while (!flight.full() && next_episode <= protocol.lastEpisode()) {
        if (const int index = next_episode++; index <= protocol.lastEpisode() && finished.count(index) == 0) {
          begin(flight, index);
        }
      }
      if (flight.empty()) {
        return;
      }
      flight.advance();
      for (Episode& episode : flight.land()) {
        finish(std::move(episode));
      }
    }
  };

  const auto work_or_fail = [&] {
    try {
      work();
    } catch (...) {
      failed = true;  // ends the other threads
      throw;
    }
  };
  std::vector<std::future<void>> others;
  try {
    while (static_cast<int>(others.size()) + 1 < threads) {
      others.push_back(std::async(std::launch::async, work_or_fail));
    }
  } catch (const std::system_error& error) {
    failed = true;
    throw pusht::RuntimeFault("cannot start thread " + std::to_string(others.size() + 2) + " of " +
                              std::to_string(threads) + ": " + error.what() + "; ask for fewer threads");
  }
  work_or_fail();  // if it throws, the destructors of the others wait for their ends
  for (std::future<void>& other : others) {
    other.get();
  }
}

}  // namespace sim2sim
