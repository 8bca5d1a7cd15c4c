// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_rviz/goal.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

#include "pusht_rviz/numbers.hpp"

namespace pusht_rviz {
namespace {

// Of the evaluator.
constexpr std::uint32_t kMaxEpisodes = 1'000'000;
constexpr std::uint32_t kMaxFirstEpisode = 1'000'000'000;
constexpr std::uint64_t kMaxRunSeed =
    std::numeric_limits<std::uint64_t>::max() - kFirstSpawnSeed - kMaxEpisodes - kMaxFirstEpisode;

std::string refused(const std::string& name, const std::string& text, const std::string& rule) {
  return name + " " + (text.empty() ? "''" : text) + ": must be " + rule;
}

template <class Number>
Reading<Number> wholeNumber(const std::string& name, const std::string& text, Number least, Number greatest) {
  const std::optional<Number> number = decimal<Number>(text);
  if (number && *number >= least && *number <= greatest) {
    return {*number};
  }
  return {{}, refused(name, text, "a whole number from " + std::to_string(least) + " to " + std::to_string(greatest))};
}

bool isNumber(const pusht_msgs::ParameterDescriptor& parameter) {
  return parameter.type == "real" || parameter.type == "integer";
}

std::string joined(const std::vector<std::string>& words) {
  return std::accumulate(
      words.begin(), words.end(), std::string(),
      [](const std::string& all, const std::string& word) { return all.empty() ? word : all + ", " + word; });
}

/// Of the numbers that a parameter takes.
std::string boundsText(const pusht_msgs::ParameterDescriptor& parameter) {
  const std::string unit = parameter.unit.empty() ? "" : " [" + parameter.unit + "]";
  if (std::isfinite(parameter.least) && std::isfinite(parameter.greatest)) {
    return "from " + shortText(parameter.least) + " to " + shortText(parameter.greatest) + unit;
  }
  if (std::isfinite(parameter.least)) {
    return "at least " + shortText(parameter.least) + unit;
  }
  return std::isfinite(parameter.greatest) ? "at most " + shortText(parameter.greatest) + unit : "";
}

/// The last of that name counts.
std::optional<std::string> textAmong(const std::vector<pusht_msgs::Parameter>& parameters, const std::string& name) {
  const auto found = std::find_if(parameters.rbegin(), parameters.rend(),
                                  [&](const auto& candidate) { return candidate.name == name; });
  return found == parameters.rend() ? std::nullopt : std::optional<std::string>(found->value);
}

/// Sets what each setting is unless the goal names it. The goal names words that differ, and they set others.
void rebase(std::vector<Setting>& settings) {
  for (Setting& setting : settings) {
    setting.base = setting.initial;
  }
  for (const Setting& word : settings) {
    if (!word.differs()) {
      continue;
    }
    for (const pusht_msgs::Preset& preset : word.parameter.presets) {
      if (preset.word != word.text) {
        continue;
      }
      for (Setting& setting : settings) {
        setting.base = textAmong(preset.settings, setting.parameter.name).value_or(setting.base);
      }
    }
  }
}

void add(const std::string& role, const SimulatorDraft& simulator, std::vector<std::string>& kind,
         std::vector<pusht_msgs::Parameter>& parameters, std::vector<Refusal>& refusals) {
  if (!simulator.kind.empty()) {
    kind = {simulator.kind};
  }
  for (const Setting& setting : simulator.settings) {
    if (!setting.differs()) {
      continue;
    }
    const std::string rule = refusalOf(setting.parameter, setting.text);
    if (!rule.empty()) {
      refusals.push_back({role + "." + setting.parameter.name, rule});
    }
  }
  parameters = simulator.named();
}

}  // namespace

Reading<std::uint32_t> readEpisodes(const std::string& text) {
  return wholeNumber<std::uint32_t>("episodes", text, 1, kMaxEpisodes);
}

Reading<std::uint64_t> readRunSeed(const std::string& text) {
  return wholeNumber<std::uint64_t>("run seed", text, 0, kMaxRunSeed);
}

Reading<std::uint32_t> readFirstEpisode(const std::string& text) {
  return wholeNumber<std::uint32_t>("first episode", text, 0, kMaxFirstEpisode);
}

Reading<std::uint32_t> episodeOfSeed(const std::string& text, std::uint64_t run_seed) {
  const std::uint64_t least = kFirstSpawnSeed + run_seed;
  const std::string least_text = std::to_string(least);
  const std::optional<std::uint64_t> seed = decimal<std::uint64_t>(text);
  if (!seed) {
    return {{}, refused("seed", text, "a whole number, at least " + least_text)};
  }
  if (*seed < least) {
    return {{}, refused("seed", text, "at least 10000 + the run's seed, " + least_text)};
  }
  if (*seed - least > kMaxFirstEpisode) {
    return {{}, refused("seed", text, "at most " + std::to_string(least + kMaxFirstEpisode))};
  }
  return {static_cast<std::uint32_t>(*seed - least)};
}

std::string rangeText(const pusht_msgs::ParameterDescriptor& parameter) {
  if (isNumber(parameter)) {
    return boundsText(parameter);
  }
  if (parameter.type == "boolean") {
    return "true or false";
  }
  return parameter.words.empty() ? "" : "one of: " + joined(parameter.words);
}

std::string nextFolder(const std::string& folder) {
  const std::size_t end = folder.find_last_not_of('/');
  if (end == std::string::npos) {
    return folder;
  }
  const std::string name = folder.substr(0, end + 1);
  const std::size_t dash = name.find_last_not_of("0123456789");
  const std::optional<std::uint32_t> number =
      dash == std::string::npos || name[dash] != '-' ? std::nullopt : decimal<std::uint32_t>(name.substr(dash + 1));
  return number ? name.substr(0, dash + 1) + std::to_string(std::uint64_t{*number} + 1) : name + "-2";
}

std::string refusalOf(const pusht_msgs::ParameterDescriptor& parameter, const std::string& text) {
  const std::string range = rangeText(parameter);
  if (parameter.type == "boolean") {
    return text == "true" || text == "false" ? "" : refused(parameter.name, text, range);
  }
  if (!isNumber(parameter)) {
    const bool known = parameter.words.empty() ||
                       std::find(parameter.words.begin(), parameter.words.end(), text) != parameter.words.end();
    return known ? "" : refused(parameter.name, text, range);
  }
  const bool whole = parameter.type == "integer";
  if (whole ? !decimal<std::int64_t>(text) : !decimal<double>(text)) {
    return refused(parameter.name, text,
                   (whole ? "a whole number" : "a decimal number") + (range.empty() ? "" : ", " + range));
  }
  const double number = whole ? static_cast<double>(*decimal<std::int64_t>(text)) : *decimal<double>(text);
  return parameter.least <= number && number <= parameter.greatest ? "" : refused(parameter.name, text, range);
}

bool Setting::differs() const {
  if (text == base) {
    return false;
  }
  const std::optional<double> number = isNumber(parameter) ? decimal<double>(text) : std::nullopt;
  return !number || number != decimal<double>(base);
}

void SimulatorDraft::type(std::size_t place, const std::string& text) {
  settings.at(place).text = text;
  std::vector<Setting*> followers;
  for (Setting& setting : settings) {
    if (&setting != &settings[place] && !setting.differs()) {
      followers.push_back(&setting);
    }
  }
  rebase(settings);
  for (Setting* const follower : followers) {
    follower->text = follower->base;
  }
}

std::vector<pusht_msgs::Parameter> SimulatorDraft::named() const {
  std::vector<pusht_msgs::Parameter> parameters;
  for (const Setting& setting : settings) {
    if (setting.differs() || !setting.described) {
      pusht_msgs::Parameter parameter;
      parameter.name = setting.parameter.name;
      parameter.value = setting.text;
      parameters.push_back(parameter);
    }
  }
  return parameters;
}

SimulatorDraft draftOf(const std::string& kind, const pusht_msgs::DescribeResponse& described,
                       const std::vector<pusht_msgs::Parameter>& chosen) {
  SimulatorDraft draft;
  draft.kind = kind;
  for (const pusht_msgs::Parameter& parameter : described.parameters) {
    const auto& descriptors = described.parameter_descriptors;
    const auto known = std::find_if(descriptors.begin(), descriptors.end(),
                                    [&](const auto& descriptor) { return descriptor.name == parameter.name; });
    Setting setting;
    setting.described = known != descriptors.end();
    if (setting.described) {
      setting.parameter = *known;
      setting.initial = known->default_value;
    } else {
      setting.parameter.name = parameter.name;  // a text that may be anything
      setting.initial = parameter.value;
    }
    setting.text = textAmong(chosen, parameter.name).value_or(setting.initial);
    draft.settings.push_back(setting);
  }
  rebase(draft.settings);
  for (Setting& setting : draft.settings) {
    setting.text = textAmong(chosen, setting.parameter.name).value_or(setting.base);
  }
  return draft;
}

Draft goalFrom(const RunDraft& run) {
  Draft draft;
  const auto take = [&](const char* field, const auto& reading, auto& values) {
    if (reading.refusal.empty()) {
      values = {reading.value};
    } else {
      draft.refusals.push_back({field, reading.refusal});
    }
  };
  take("episodes", readEpisodes(run.episodes), draft.goal.episodes);
  if (!draft.goal.episodes.empty() && draft.goal.episodes.front() == run.requested_episodes) {
    draft.goal.episodes.clear();
  }
  draft.goal.out = {run.out};
  take("run_seed", readRunSeed(run.run_seed), draft.goal.seed);
  take("first_episode", readFirstEpisode(run.first_episode), draft.goal.first_episode);
  if (run.spawned && !draft.goal.seed.empty()) {
    const Reading<std::uint32_t> episode = episodeOfSeed(run.spawn_seed, draft.goal.seed.front());
    if (!episode.refusal.empty()) {
      draft.refusals.push_back({"spawn_seed", episode.refusal});
    }
  }
  if (!run.policy.empty()) {
    draft.goal.policy_namespace = {run.policy};
  }
  if (run.rate) {
    draft.goal.rate = {*run.rate};
  }
  add("reference", run.reference, draft.goal.reference, draft.goal.reference_parameters, draft.refusals);
  add("engine", run.engine, draft.goal.engine, draft.goal.engine_parameters, draft.refusals);
  return draft;
}

}  // namespace pusht_rviz
