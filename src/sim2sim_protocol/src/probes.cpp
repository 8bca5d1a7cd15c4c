// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/probes.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/split.hpp"

namespace sim2sim {
namespace {

constexpr const char* kReanchored = "engine_reanchored_";
constexpr const char* kVariant = "variant_";
constexpr const char* kClosedVariant = "closed_variant_";

/// What follows `beginning` in `text`; empty if it begins otherwise.
std::string restAfter(const std::string& beginning, const std::string& text) {
  return text.rfind(beginning, 0) == 0 ? text.substr(beginning.size()) : "";
}

std::vector<std::string> splitAtCommas(const std::string& text) {
  return text.empty() ? std::vector<std::string>() : pusht::split(text, ',');
}

void addOnce(const char* option, const std::string& entry, Probe&& probe, std::vector<Probe>& probes) {
  if (std::find(probes.begin(), probes.end(), probe) != probes.end()) {
    throw pusht::InvalidInput(std::string(option) + " " + entry + ": is named twice");
  }
  probes.push_back(std::move(probe));
}

bool isDigit(char character) { return '0' <= character && character <= '9'; }

bool consistsOf(const std::string& characters, const std::string& text) {
  return !text.empty() && text.find_first_not_of(characters) == std::string::npos;
}

/// Whether `variant` is NAME=VALUE, or several joined by ':'.
bool areSettings(const std::string& variant) {
  const std::string word = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_0123456789";
  const std::vector<std::string> settings = pusht::split(variant, ':');
  return std::all_of(settings.begin(), settings.end(), [&](const std::string& setting) {
    const std::size_t sign = setting.find('=');
    return sign != std::string::npos && consistsOf(word, setting.substr(0, sign)) && !isDigit(setting.front()) &&
           consistsOf(word + ".+-", setting.substr(sign + 1));
  });
}

}  // namespace

const std::vector<Probe>& floorProbes() {
  static const std::vector<Probe> probes = {{"floor_1e-9", ProbedWorld::kReference, 1e-9, 0},
                                            {"floor_1e-6", ProbedWorld::kReference, 1e-6, 0}};
  return probes;
}

Probe stateResetReplay(int every) {
  if (every < 1 || every > pusht::kHorizon) {
    throw pusht::InvalidInput("reanchor " + std::to_string(every) + ": must be from 1 to " +
                              std::to_string(pusht::kHorizon) + " control steps");
  }
  return {kReanchored + std::to_string(every), ProbedWorld::kEngine, 0.0, every};
}

Probe modelVariant(const std::string& variant, bool closed) {
  constexpr std::size_t kLongest = 200;  // [bytes] it becomes the name of a file
  if (variant.size() > kLongest || !areSettings(variant)) {
    throw pusht::InvalidInput("model variant '" + variant + "': must be NAME=VALUE, or several joined by ':'");
  }
  return {(closed ? kClosedVariant : kVariant) + variant, ProbedWorld::kVariant, 0.0, 0, variant, closed};
}

std::vector<Probe> probesOf(const RunOptions& options) {
  std::vector<Probe> probes = options.floor ? floorProbes() : std::vector<Probe>();
  for (const int every : options.reanchor) {
    addOnce("reanchor", std::to_string(every), stateResetReplay(every), probes);
  }
  const auto add_variants = [&](const char* option, const std::vector<std::string>& variants, bool closed) {
    for (const std::string& variant : variants) {
      if (variant != kDefaultVariants) {
        addOnce(option, variant, modelVariant(variant, closed), probes);
      }
    }
  };
  add_variants("model_variants", options.model_variants, false);
  add_variants("closed_variants", options.closed_variants, true);
  return probes;
}

std::vector<std::string> variantsOf(const RunOptions& options) {
  std::vector<std::string> variants = options.model_variants;
  std::copy_if(options.closed_variants.begin(), options.closed_variants.end(), std::back_inserter(variants),
               [&](const std::string& variant) {
                 return std::find(variants.begin(), variants.end(), variant) == variants.end();
               });
  return variants;
}

std::vector<int> reanchorFrom(const std::string& text) {
  std::vector<int> steps;
  for (const std::string& number : splitAtCommas(text)) {
    const std::optional<int> every = pusht::decimal<int>(number);
    if (!every) {
      throw pusht::InvalidInput("reanchor '" + text + "': must be numbers of control steps like 1,5,20");
    }
    steps.push_back(*every);
  }
  return steps;
}

std::vector<std::string> modelVariantsFrom(const std::string& text) {
  std::vector<std::string> variants = splitAtCommas(text);
  for (const std::string& variant : variants) {
    if (variant != kDefaultVariants) {
      modelVariant(variant, false);  // throws if it is none
    }
  }
  return variants;
}

Probe probeFrom(const std::string& name) {
  for (const Probe& probe : floorProbes()) {
    if (probe.name == name) {
      return probe;
    }
  }
  if (const auto every = pusht::decimal<int>(restAfter(kReanchored, name))) {
    return stateResetReplay(*every);
  }
  for (const bool closed : {false, true}) {
    if (const std::string variant = restAfter(closed ? kClosedVariant : kVariant, name); !variant.empty()) {
      return modelVariant(variant, closed);
    }
  }
  throw pusht::InvalidInput("probe '" + name + "': must be floor_1e-9, floor_1e-6, " + kReanchored + "K, " + kVariant +
                            "NAME=VALUE or " + kClosedVariant + "NAME=VALUE");
}

pusht::Trace runProbe(const Probe& probe, const pusht::Trace& reference, pusht::BatchSimulator& world, std::size_t lane,
                      const std::function<void(int)>& before_step) {
  const int in_lane = static_cast<int>(lane);
  pusht::Trace trace;
  trace.states.push_back(world.state(in_lane));
  trace.actions = reference.actions;
  std::vector<std::optional<pusht::Action>> actions(static_cast<std::size_t>(world.lanes()));
  for (int step = 0; step < static_cast<int>(reference.steps()); ++step) {
    before_step(step);
    const auto k = static_cast<std::size_t>(step);
    if (probe.reset_every > 0 && step > 0 && step % probe.reset_every == 0) {
      world.reset(in_lane, reference.states[k]);
    }
    actions[lane] = reference.actions[k];
    world.step(actions);
    trace.states.push_back(world.state(in_lane));
  }
  return trace;
}

}  // namespace sim2sim
