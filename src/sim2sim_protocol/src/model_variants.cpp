// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/model_variants.hpp"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/split.hpp"
#include "pusht_task/task.hpp"
#include "sim2sim_protocol/probes.hpp"

namespace sim2sim {
namespace {

/// A variant's parameters: those of the reference but for the values that it names.
struct Variant {
  std::string name;
  pusht::ParameterSet parameters;
};

[[noreturn]] void refuse(const pusht::SimulatorKind& kind, const std::string& text, const std::string& why) {
  throw pusht::InvalidInput("model variant " + text + ": of the reference " + kind.name + ": " + why);
}

/// Variant that may be the reference itself.
Variant variantOf(const pusht::SimulatorKind& kind, const pusht::ParameterSet& reference, const std::string& text) {
  Variant variant{"", reference};
  std::set<std::string> set;
  try {
    for (const std::string& setting : pusht::split(text, ':')) {
      const std::size_t equals = setting.find('=');
      const std::string name = setting.substr(0, equals);
      if (!set.insert(name).second) {
        throw pusht::InvalidInput("parameter " + name + ": must be set once");
      }
      variant.parameters.set(name, setting.substr(equals + 1));
      variant.name.append(variant.name.empty() ? "" : ":").append(name).append("=");
      variant.name += pusht::textOf(variant.parameters.at(name).value);
    }
  } catch (const pusht::InvalidInput& error) {
    refuse(kind, text, error.what());
  }
  return variant;
}

Variant differentVariantOf(const pusht::SimulatorKind& kind, const pusht::ParameterSet& reference,
                           const std::string& text) {
  Variant variant = variantOf(kind, reference, text);
  if (variant.parameters == reference) {
    refuse(kind, text, "must differ from the reference");
  }
  return variant;
}

/// Default variants that are not the reference itself; there may be none.
std::vector<Variant> defaultVariantsOrNone(const pusht::SimulatorKind& kind, const pusht::ParameterSet& reference) {
  std::vector<Variant> variants;
  for (const std::string& text : kind.variants) {
    Variant variant = variantOf(kind, reference, text);
    if (!(variant.parameters == reference)) {
      variants.push_back(std::move(variant));
    }
  }
  return variants;
}

/// Default variants that are not the reference itself.
std::vector<Variant> defaultVariants(const pusht::SimulatorKind& kind, const pusht::ParameterSet& reference) {
  std::vector<Variant> variants = defaultVariantsOrNone(kind, reference);
  if (variants.empty()) {
    throw pusht::InvalidInput(std::string("model variants ") + kDefaultVariants + ": the reference " + kind.name +
                              " has none" + (kind.variants.empty() ? "" : " but itself") +
                              "; name them, NAME=VALUE,...");
  }
  return variants;
}

/// `texts` by the names of their parameters; `option` lists them.
std::vector<std::string> named(const pusht::SimulatorKind& kind, const pusht::ParameterSet& reference,
                               const std::string& option, const std::vector<std::string>& texts) {
  std::vector<Variant> variants;
  const auto add = [&](Variant variant) {
    for (const Variant& before : variants) {
      if (before.parameters == variant.parameters) {
        throw pusht::InvalidInput(
            option + " " + variant.name +
            (before.name == variant.name ? ": is named twice" : ": is the same model as " + before.name));
      }
    }
    variants.push_back(std::move(variant));
  };
  for (const std::string& text : texts) {
    if (text == kDefaultVariants) {
      for (Variant& variant : defaultVariants(kind, reference)) {
        add(std::move(variant));
      }
    } else {
      add(differentVariantOf(kind, reference, text));
    }
  }
  std::vector<std::string> names;
  std::transform(variants.begin(), variants.end(), std::back_inserter(names),
                 [](const Variant& variant) { return variant.name; });
  return names;
}

}  // namespace

void nameVariants(const pusht::SimulatorKind& kind, const pusht::ParameterSet& parameters, RunOptions& options) {
  options.model_variants = named(kind, parameters, "model_variants", options.model_variants);
  options.closed_variants = named(kind, parameters, "closed_variants", options.closed_variants);
  probesOf(options);  // throws if one cannot be the name of a rollout
}

std::vector<pusht::SimulatorModel> loadVariants(const pusht::SimulatorKind& kind, const pusht::ParameterSet& parameters,
                                                const RunOptions& options) {
  const pusht::Task& task = pusht::taskNamed(options.task);
  std::vector<pusht::SimulatorModel> models;
  for (const std::string& variant : variantsOf(options)) {
    models.push_back(kind.load(differentVariantOf(kind, parameters, variant).parameters, task));
  }
  return models;
}

std::vector<LoadedVariant> loadDefaultVariants(const pusht::SimulatorKind& kind, const pusht::ParameterSet& parameters,
                                               const pusht::Task& task) {
  std::vector<LoadedVariant> loaded;
  for (const Variant& variant : defaultVariantsOrNone(kind, parameters)) {
    loaded.push_back({variant.name, kind.load(variant.parameters, task)});
  }
  return loaded;
}

VariantWorlds worldsOf(const std::vector<pusht::SimulatorModel>& variants) {
  VariantWorlds worlds;
  std::transform(variants.begin(), variants.end(), std::back_inserter(worlds),
                 [](const pusht::SimulatorModel& variant) { return variant.make_lanes(1); });
  return worlds;
}

}  // namespace sim2sim
