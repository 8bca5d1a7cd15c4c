// SPDX-License-Identifier: BSD-3-Clause
#include "live/participants.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "bag/messages.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "sim2sim_protocol/model_variants.hpp"
#include "sim2sim_protocol/probes.hpp"
#include "sim2sim_protocol/results/provenance.hpp"
#include "sim2sim_serving/conversions.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

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

void requirePolicy(const LiveRequest& request, const LiveNodes& nodes) {
  const std::string& name = nodes.describePolicy().name;
  if (!request.policy.empty() && request.policy != name) {
    throw pusht::InvalidInput("policy " + request.policy + ": " + request.services.policy + " serves " + name +
                              "; name no policy if its node is started elsewhere, or this one");
  }
}

VariantWorlds variantWorldsOf(RunOptions& protocol, const LiveNodes& nodes) {
  const std::vector<std::string> asked = variantsOf(protocol);
  if (asked.empty()) {
    return {};
  }
  const pusht_msgs::DescribeResponse& node = nodes.describe(kReferenceClosed);
  const pusht::SimulatorKind* const kind = pusht::SimulatorKinds::installed().find(node.name);
  if (kind == nullptr || kind->version != node.version) {
    throw pusht::BadDependency("model variants " + pusht::joined(asked) + ": the reference is " + node.name + " " +
                               node.version + ", but here " +
                               (kind == nullptr ? "no such kind is installed" : "version " + kind->version + " is") +
                               "; variants run in the evaluator's process, with the reference's own kind");
  }
  const pusht::ParameterSet parameters =
      pusht::merged(kind->defaults(pusht::taskNamed(protocol.task)), pusht::withoutTask(node.parameters));
  nameVariants(*kind, parameters, protocol);
  return worldsOf(loadVariants(*kind, parameters, protocol));
}

RunConfiguration configurationOf(const LiveRequest& request, const LiveNodes& nodes) {
  RunConfiguration configuration;
  configuration.protocol = request.protocol;
  configuration.smoke = request.smoke;
  configuration.policy = nodes.describePolicy().name;
  configuration.reference = recordOf(nodes.describe(kReferenceClosed));
  configuration.engine = recordOf(nodes.describe(kEngineClosed));
  configuration.reference.add(loopOf(request.simulators.reference));
  configuration.engine.add(loopOf(request.simulators.engine));
  return configuration;
}

nlohmann::ordered_json runProvenance(const RunConfiguration& configuration, const LiveNodes& nodes) {
  nlohmann::ordered_json result = provenance(configuration, pusht::provenanceOf(nodes.describePolicy()),
                                             pusht::provenanceOf(nodes.describe(kReferenceClosed)),
                                             pusht::provenanceOf(nodes.describe(kEngineClosed)));
  result["nodes"]["policy"] = participant(nodes.describePolicy());
  for (const Mode mode : kModes) {
    result["nodes"][modeName(mode)] = participant(nodes.describe(mode));
  }
  return result;
}

std::vector<Input> inputsOf(const LiveRequest& request, const LiveNodes& nodes) {
  std::vector<Input> inputs = {{"policy", nodes.describePolicy().name}, {"starts", request.starts}};
  for (const Mode mode : kModes) {
    const std::vector<Input> files = filesIn(pusht::provenanceOf(nodes.describe(mode)));
    inputs.insert(inputs.end(), files.begin(), files.end());
  }
  return inputs;
}

Picture pictureOf(const RunConfiguration& configuration, const LiveNodes& nodes) {
  std::array<std::string, kModeCount> prefixes;
  for (const Mode mode : kModes) {
    prefixes[mode] = nodes.describe(mode).frame_prefix;
  }
  return Picture::of(configuration, prefixes);
}

WorldNames worldNamesOf(const LiveRequest& request, const LiveNodes& nodes) {
  WorldNames worlds;
  for (const Mode mode : kModes) {
    worlds[mode] = {request.services.worlds[mode] + "/state", nodes.describe(mode).frame_prefix};
  }
  return worlds;
}

}  // namespace sim2sim
