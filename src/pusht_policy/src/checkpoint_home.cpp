// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/checkpoint_home.hpp"

#include <nlohmann/json.hpp>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/json_text.hpp"

namespace pusht {
namespace {

using nlohmann::json;

std::string textOf(const json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

/// First simulator of demonstrations with this origin. Throws json::exception if it names none.
CheckpointHome homeIn(const json& origin) {
  if (!origin.contains("simulators")) {  // the first format had only a name
    return {origin.at("simulator").get<std::string>()};
  }
  const json& first = origin.at("simulators").at(0);
  CheckpointHome home{first.at("name").get<std::string>()};
  for (const auto& [name, value] : first.at("parameters").items()) {
    if (value.is_string() && value.get<std::string>().rfind("sha256:", 0) == 0) {
      throw InvalidInput("has a file as " + name +
                         ", which is known by its content alone; name the policy's reference");
    }
    home.settings.push_back(std::string(name).append("=").append(textOf(value)));
  }
  return home;
}

}  // namespace

CheckpointHome homeOf(const std::filesystem::path& checkpoint) {
  const std::filesystem::path path = provenancePath(checkpoint);
  const std::string text = readFile(path, "provenance", kLargestSmallFile);
  try {
    return homeIn(parseJson(text).at("demonstrations").at("bags").at(0).at("origin"));
  } catch (InvalidInput& error) {
    error.addContext("provenance " + path.string() + ": home");
    throw;
  } catch (const json::exception&) {
    throw InvalidInput("provenance " + path.string() + ": must name the simulator of the demonstrations");
  }
}

}  // namespace pusht
