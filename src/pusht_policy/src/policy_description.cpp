// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/policy_description.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <string_view>

#include "pusht_policy/formats.hpp"
#include "pusht_task/clipped.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/gym_pusht.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/types.hpp"

namespace pusht {
namespace {

using nlohmann::json;
using Shape = PolicyDescription::Shape;

constexpr std::size_t kLongestDescription = 65'536;           // [bytes]
constexpr std::array kDistributions = {"normal", "uniform"};  // in the order of the enumeration

/// Text of a JSON value or key for a message, on one line.
std::string inMessage(const json& value) { return clipped(value.dump(), 80); }

[[noreturn]] void refuseValue(const std::string& where, const std::string& key, const json& value,
                              const std::string& rule) {
  throw InvalidInput(where + ": " + key + " " + inMessage(value) + ": must be " + rule);
}

/// JSON in which no object has a key twice.
json parseDescription(const std::string& text, const std::string& where) {
  if (text.size() > kLongestDescription) {
    throw InvalidInput(where + ": has " + std::to_string(text.size()) + " bytes, must have at most " +
                       std::to_string(kLongestDescription));
  }
  std::vector<std::set<std::string>> objects;  // keys of those that are open
  const auto check = [&](int /*depth*/, json::parse_event_t event, const json& parsed) {
    if (event == json::parse_event_t::object_start) {
      objects.emplace_back();
    } else if (event == json::parse_event_t::object_end) {
      objects.pop_back();
    } else if (event == json::parse_event_t::key && !objects.back().insert(parsed.get<std::string>()).second) {
      throw InvalidInput(where + ": key " + inMessage(parsed) + " is there twice");
    }
    return true;
  };
  std::size_t bad = text.find('\0') + 1;  // where the parser would see the end
  try {
    json root = json::parse(text, check);
    if (bad == 0) {
      return root;
    }
  } catch (const json::parse_error& error) {
    bad = error.byte;
  } catch (const json::out_of_range&) {
    throw InvalidInput(where + ": must have numbers within double");
  }
  throw InvalidInput(where + ": must be JSON, but is not at byte " + std::to_string(bad));
}

void requireKeys(const json& object, const std::vector<std::string>& known, const std::string& where) {
  if (!object.is_object()) {
    throw InvalidInput(where + ": " + inMessage(object) + " must be an object with the keys " + joined(known));
  }
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      throw InvalidInput(where + ": key " + inMessage(key) + " is unknown; the keys are " + joined(known));
    }
  }
}

const json& valueOf(const json& object, const char* key, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) {
    throw InvalidInput(where + ": must have the key " + key);
  }
  return *found;
}

bool isWholeNumber(const json& value, int most) { return value.is_number_integer() && value >= 1 && value <= most; }

int countFrom(const json& object, const std::string& key, int most, const std::string& what, const std::string& where) {
  const json& value = valueOf(object, key.c_str(), where);
  if (!isWholeNumber(value, most)) {
    refuseValue(where, key, value, "a whole number from 1 to " + std::to_string(most) + what);
  }
  return value.get<int>();
}

Shape shapeFrom(const json& object, const std::string& where) {
  constexpr int kMost = PolicyDescription::kMostNumbers;
  const json& value = valueOf(object, "shape", where);
  const auto is_number = [](const json& number) { return isWholeNumber(number, kMost); };
  bool sound = value.is_array() && !value.empty() && value.size() <= PolicyDescription::kMostDimensions &&
               std::all_of(value.begin(), value.end(), is_number);
  std::int64_t numbers = 1;
  for (std::size_t i = 0; sound && i < value.size(); ++i) {
    numbers *= value[i].get<int>();
    sound = numbers <= kMost;
  }
  if (!sound) {
    refuseValue(where, "shape", value,
                "1 to " + std::to_string(PolicyDescription::kMostDimensions) +
                    " whole numbers whose product is at most " + std::to_string(kMost) +
                    ", without the one for the rollouts");
  }
  return value.get<Shape>();
}

PolicyDescription::Distribution distributionFrom(const json& object, const std::string& where) {
  const json& value = valueOf(object, "distribution", where);
  const auto found =
      std::find_if(kDistributions.begin(), kDistributions.end(), [&](const char* name) { return value == name; });
  if (found == kDistributions.end()) {
    refuseValue(where, "distribution", value, R"("normal" or "uniform")");
  }
  return static_cast<PolicyDescription::Distribution>(found - kDistributions.begin());
}

/// One of `words`, by its index.
std::size_t wordFrom(const json& object, const char* key, const std::vector<std::string>& words,
                     const std::string& where) {
  const json& value = valueOf(object, key, where);
  const auto found = std::find_if(words.begin(), words.end(), [&](const std::string& word) { return value == word; });
  if (found == words.end()) {
    refuseValue(where, key, value, "one of " + joined(words));
  }
  return static_cast<std::size_t>(found - words.begin());
}

PolicyInterface interfaceFrom(const json& root, const std::string& where) {
  PolicyInterface interface;
  if (root.contains("interface")) {
    interface.name = static_cast<PolicyInterface::Name>(wordFrom(root, "interface", policyInterfaceNames(), where));
  }
  if (interface.name == PolicyInterface::Name::kGymKeypoints) {
    const json& keypoints = valueOf(root, "keypoints", where);
    const auto is = [&](std::size_t count) { return keypoints == count; };
    if (!is(gym_pusht::kCorners) && !is(gym_pusht::kScattered)) {
      refuseValue(where, "keypoints", keypoints, "8, the tee's corners, or 9, those of Diffusion Policy");
    }
    interface.keypoints = keypoints.get<int>();
    interface.agent_first = wordFrom(root, "agent", {"first", "last"}, where) == 0;
  } else {
    for (const char* key : {"keypoints", "agent"}) {
      if (root.contains(key)) {
        throw InvalidInput(where + ": key " + key + " must be left out with the interface " + interface.text());
      }
    }
  }
  return interface;
}

/// ", state float [1, 64]"; nothing for an empty shape.
std::string tensorText(const std::string& name, const Shape& shape) {
  std::string text = name + "float [1";
  for (const int size : shape) {
    text += ", " + std::to_string(size);
  }
  return text + "]";
}

}  // namespace

std::string PolicyDescription::inputs() const {
  const int numbers = interface.numbers();
  return tensorText("", described ? Shape{observations, numbers} : Shape{numbers}) +
         (state.empty() ? "" : tensorText(", state ", state)) + (noise.empty() ? "" : tensorText(", noise ", noise));
}

std::string PolicyDescription::outputs() const {
  constexpr int kNumbers = std::tuple_size<Action>::value;
  return tensorText("", described ? Shape{actions, kNumbers} : Shape{kNumbers}) +
         (state.empty() ? "" : tensorText(", state ", state));
}

std::size_t numbersIn(const Shape& shape) {
  std::size_t numbers = shape.empty() ? 0 : 1;
  for (const int size : shape) {
    numbers *= static_cast<std::size_t>(size);
  }
  return numbers;
}

PolicyDescription descriptionFrom(const std::string& text, const std::string& where) {
  const json root = parseDescription(text, where);
  requireKeys(root,
              {"format", "observations", "actions", "execute", "state", "noise", "interface", "keypoints", "agent"},
              where);
  const json& format = valueOf(root, "format", where);
  if (format != kDescriptionFormat) {
    refuseValue(where, "format", format, std::to_string(kDescriptionFormat) + ", the one that this version reads");
  }
  PolicyDescription description;
  description.described = true;
  description.interface = interfaceFrom(root, where);
  description.observations = countFrom(root, "observations", PolicyDescription::kMostObservations, "", where);
  description.actions = countFrom(root, "actions", PolicyDescription::kMostActions, "", where);
  description.execute = root.contains("execute")
                            ? countFrom(root, "execute", description.actions, ", the actions of an answer", where)
                            : description.actions;
  if (root.contains("state")) {
    requireKeys(root["state"], {"shape"}, where + ": state");
    description.state = shapeFrom(root["state"], where + ": state");
  }
  if (root.contains("noise")) {
    requireKeys(root["noise"], {"shape", "distribution"}, where + ": noise");
    description.noise = shapeFrom(root["noise"], where + ": noise");
    description.distribution = distributionFrom(root["noise"], where + ": noise");
  }
  return description;
}

json toJson(const PolicyDescription& description) {
  json object = {{"format", kDescriptionFormat},
                 {"observations", description.observations},
                 {"actions", description.actions},
                 {"execute", description.execute}};
  const PolicyInterface& interface = description.interface;
  if (!(interface == PolicyInterface())) {
    object["interface"] = policyInterfaceNames()[static_cast<std::size_t>(interface.name)];
  }
  if (interface.name == PolicyInterface::Name::kGymKeypoints) {
    object["keypoints"] = interface.keypoints;
    object["agent"] = interface.agent_first ? "first" : "last";
  }
  if (!description.state.empty()) {
    object["state"] = {{"shape", description.state}};
  }
  if (!description.noise.empty()) {
    object["noise"] = {{"shape", description.noise},
                       {"distribution", kDistributions.at(static_cast<std::size_t>(description.distribution))}};
  }
  return object;
}

void addDescription(const PolicyDescription& description, json& object) {
  if (description.described) {
    object["description"] = toJson(description);
  }
}

void addNoise(const PolicyDescription& description, json& provenance) {
  if (description.isStochastic()) {
    provenance["noise"] = toJson(description)["noise"];
    provenance["noise"]["drawn_by"] = "the suite, one stream of PCG64 for each rollout";
  }
}

}  // namespace pusht
