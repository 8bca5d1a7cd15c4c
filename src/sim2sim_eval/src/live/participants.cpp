// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/live/participants.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "pusht_task/error.hpp"
#include "sim2sim_eval/bag/messages.hpp"
#include "sim2sim_protocol/results/provenance.hpp"

namespace sim2sim {
namespace {

/// Name, version and parameters of a node.
nlohmann::ordered_json participant(const pusht_msgs::DescribeResponse& node) {
  nlohmann::ordered_json parameters = nlohmann::ordered_json::object();
  for (const pusht_msgs::Parameter& parameter : node.parameters) {
    parameters[parameter.name] = parameter.value;
  }
  return {{"name", node.name},
          {"version", node.version},
          {"instance_id", node.instance_id},
          {"parameters", parameters},
          {"parameters_hash", node.parameters_hash}};
}

}  // namespace

void requirePolicy(const LiveRequest& request, const Cast& cast) {
  const std::string& name = cast.describePolicy().name;
  if (!request.policy.empty() && request.policy != name) {
    throw pusht::InvalidInput("policy " + request.policy + ": " + request.services.policy + " serves " + name +
                              "; name no policy if its node is started elsewhere, or this one");
  }
}

RunConfiguration configurationOf(const LiveRequest& request, const Cast& cast) {
  RunConfiguration configuration;
  configuration.protocol = request.protocol;
  configuration.smoke = request.smoke;
  configuration.policy = cast.describePolicy().name;
  configuration.reference = recordOf(cast.describe(kReferenceClosed));
  configuration.engine = recordOf(cast.describe(kEngineClosed));
  return configuration;
}

nlohmann::ordered_json originOf(const RunConfiguration& configuration, const Cast& cast) {
  nlohmann::ordered_json result =
      provenance(configuration, provenanceOf(cast.describePolicy()), provenanceOf(cast.describe(kReferenceClosed)),
                 provenanceOf(cast.describe(kEngineClosed)));
  result["nodes"]["policy"] = participant(cast.describePolicy());
  for (const Mode mode : kModes) {
    result["nodes"][modeName(mode)] = participant(cast.describe(mode));
  }
  return result;
}

std::vector<Input> inputsOf(const LiveRequest& request, const Cast& cast) {
  std::vector<Input> inputs = {{"policy", cast.describePolicy().name}, {"starts", request.starts}};
  for (const Mode mode : kModes) {
    const std::vector<Input> files = filesIn(provenanceOf(cast.describe(mode)));
    inputs.insert(inputs.end(), files.begin(), files.end());
  }
  return inputs;
}

Picture pictureOf(const RunConfiguration& configuration, const Cast& cast) {
  std::array<std::string, kModeCount> prefixes;
  for (const Mode mode : kModes) {
    prefixes[mode] = cast.describe(mode).frame_prefix;
  }
  return Picture::of(configuration, prefixes);
}

WorldNames worldNamesOf(const LiveRequest& request, const Cast& cast) {
  WorldNames worlds;
  for (const Mode mode : kModes) {
    worlds[mode] = {request.services.worlds[mode] + "/state", cast.describe(mode).frame_prefix};
  }
  return worlds;
}

}  // namespace sim2sim
