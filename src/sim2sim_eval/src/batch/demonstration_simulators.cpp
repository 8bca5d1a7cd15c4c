// SPDX-License-Identifier: BSD-3-Clause
#include "batch/demonstration_simulators.hpp"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>
#include <variant>

#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/split.hpp"

namespace sim2sim {
namespace {

/// "NAME=VALUE", or "NAME=LEAST..GREATEST".
struct Setting {
  explicit Setting(const std::string& text) : whole(text) {
    const std::size_t equals = text.find('=');
    const std::size_t dots = text.find("..", equals == std::string::npos ? 0 : equals);
    if (equals == std::string::npos || dots == std::string::npos) {
      return;
    }
    name = text.substr(0, equals);
    least = text.substr(equals + 1, dots - equals - 1);
    greatest = text.substr(dots + 2);
    is_range = pusht::decimal<double>(least) && pusht::decimal<double>(greatest);  // "scene=../mine.xml" is none
  }

  std::string whole;
  bool is_range = false;
  std::string name{};  // of a range
  std::string least{};
  std::string greatest{};
};

Draw drawFrom(const Setting& range, const pusht::ParameterSet& parameters) {
  const pusht::ParameterDescriptor& parameter = parameters.at(range.name).descriptor;
  const std::string type = parameter.type();
  if (type != "real" && type != "integer") {
    throw pusht::InvalidInput("draw '" + range.whole + "': " + range.name + " is of type " + type +
                              "; must be a real or an integer");
  }
  Draw draw{range.name, parameter.read(range.least), parameter.read(range.greatest)};
  if (draw.greatest < draw.least) {
    throw pusht::InvalidInput("draw '" + range.whole + "': must not end below its beginning");
  }
  return draw;
}

/// The numbers that a parameter takes between two others.
std::vector<double> numbersBetween(const pusht::ParameterDescriptor& parameter, double least, double greatest) {
  std::vector<double> numbers;
  std::copy_if(parameter.numbers.begin(), parameter.numbers.end(), std::back_inserter(numbers),
               [&](double number) { return least <= number && number <= greatest; });
  return numbers;
}

}  // namespace

std::string Draw::value(std::uint64_t seed, const pusht::SimulatorKind& kind) const {
  const pusht::ParameterSet defaults = kind.defaults();
  const pusht::ParameterDescriptor& descriptor = defaults.at(parameter).descriptor;
  pusht::NumpyGenerator generator(seed, "draw " + kind.name + "." + parameter);
  const double share = generator.random();
  if (const auto* const low = std::get_if<std::int64_t>(&least); low != nullptr) {
    const auto count = static_cast<double>(std::get<std::int64_t>(greatest) - *low + 1);
    return pusht::textOf(*low + static_cast<std::int64_t>(share * count));
  }
  const double low = std::get<double>(least);
  const double high = std::get<double>(greatest);
  if (!descriptor.numbers.empty()) {
    const std::vector<double> numbers = numbersBetween(descriptor, low, high);
    return pusht::textOf(numbers.at(static_cast<std::size_t>(share * static_cast<double>(numbers.size()))));
  }
  return pusht::textOf(low + (high - low) * share);
}

DemonstrationSimulators::DemonstrationSimulators(const std::vector<std::string>& simulators,
                                                 const std::vector<std::string>& settings, const pusht::Task& task)
    : task_(&task) {
  if (simulators.empty()) {
    throw pusht::InvalidInput("simulators: must be one or more");
  }
  if (simulators.size() > 1 && !settings.empty()) {
    throw pusht::InvalidInput("setting '" + settings.front() + "': must be with its simulator, as in " +
                              simulators.front() + ":" + settings.front());
  }
  std::set<std::string> named;  // with what is drawn
  for (const std::string& simulator : simulators) {
    std::vector<std::string> parts = pusht::split(simulator, ':');
    parts.insert(parts.end(), settings.begin(), settings.end());
    std::vector<std::string> fixed;
    std::vector<Setting> ranges;
    for (auto part = parts.begin() + 1; part != parts.end(); ++part) {
      if (Setting setting(*part); setting.is_range) {
        ranges.push_back(setting);
      } else {
        fixed.push_back(*part);
      }
    }
    SimulatorChoice choice = chooseSimulator(parts.front(), fixed);
    requireNoLoop(choice, "a demonstration");
    setTask(task, {choice});
    Entry entry{textOf(choice), LoadedSimulator(choice), {}, nullptr};
    std::string whole = entry.name;
    for (const Setting& range : ranges) {
      whole += ":" + range.whole;
      const auto is_drawn = [&](const auto& other) { return other.parameter == range.name; };
      const bool is_set = choice.parameters.at(range.name).set_by_name;
      if (is_set || std::any_of(entry.draws.begin(), entry.draws.end(), is_drawn)) {
        throw pusht::InvalidInput("draw '" + range.whole + "': " + range.name + " must be given once");
      }
      entry.draws.push_back(drawFrom(range, choice.parameters));
    }
    if (!named.insert(whole).second) {
      throw pusht::InvalidInput("simulators " + pusht::joined(simulators) + ": must be named once each");
    }
    entries_.push_back(std::move(entry));
  }
}

pusht::DemonstrationWorld DemonstrationSimulators::worldOf(std::uint64_t seed) {
  Entry& entry = entries_[seed % entries_.size()];
  const pusht::SimulatorKind& kind = entry.simulator.kind;
  if (entry.draws.empty()) {
    if (entry.world == nullptr) {
      entry.world = entry.simulator.model.make_world();
    }
    return {entry.world, entry.name};
  }
  pusht::DemonstrationWorld world{nullptr, entry.name};
  pusht::ParameterSet parameters = entry.simulator.model.parameters;
  try {
    for (const Draw& draw : entry.draws) {
      world.drawn.emplace_back(draw.parameter, draw.value(seed, kind));
      parameters.set(draw.parameter, world.drawn.back().second);
    }
    world.world = kind.load(parameters, *task_).make_world();
  } catch (pusht::Error& error) {
    error.addContext("demonstration of seed " + std::to_string(seed));
    throw;
  }
  return world;
}

nlohmann::json DemonstrationSimulators::description() const {
  nlohmann::json simulators = nlohmann::json::array();
  for (const Entry& entry : entries_) {
    const SimulatorRecord record = entry.simulator.record();
    nlohmann::json changed = nlohmann::json::object();
    for (const std::string& name : record.changed) {
      changed[name] = record.parameters.at(name);
    }
    nlohmann::json drawn = nlohmann::json::object();
    for (const Draw& draw : entry.draws) {
      for (const pusht::ParameterValue& end : {draw.least, draw.greatest}) {
        std::visit([&](const auto& value) { drawn[draw.parameter].push_back(value); }, end);
      }
    }
    simulators.push_back({{"name", record.name},
                          {"parameters", changed},
                          {"drawn", drawn},
                          {"provenance", entry.simulator.provenance()}});
  }
  return simulators;
}

}  // namespace sim2sim
