// SPDX-License-Identifier: BSD-3-Clause
/// Nodes of a live run as its results name them: configuration, provenance, inputs, picture.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "bag/run_bag.hpp"
#include "live/live_nodes.hpp"
#include "live/picture.hpp"
#include "live/request.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"

namespace sim2sim {

/// Throws InvalidInput if `request` names a policy and the policy's node serves another.
void requirePolicy(const LiveRequest& request, const LiveNodes& nodes);

/// Worlds of the model variants that `protocol` asks for, whose names it then has (nameVariants()). They run in this
/// process, so the reference's kind must be installed here. Throws BadDependency if it is not, or in another version
/// than the node's, and as loadVariants().
VariantWorlds variantWorldsOf(RunOptions& protocol, const LiveNodes& nodes);

/// Configuration of the run: the request, with policy and simulators as the nodes describe them.
RunConfiguration configurationOf(const LiveRequest& request, const LiveNodes& nodes);

/// Content of provenance.json, with all nodes.
nlohmann::ordered_json runProvenance(const RunConfiguration& configuration, const LiveNodes& nodes);

/// Files that the run and its nodes have read, as far as the nodes report them.
std::vector<Input> inputsOf(const LiveRequest& request, const LiveNodes& nodes);

/// Picture of the run, in the frames of the nodes.
Picture pictureOf(const RunConfiguration& configuration, const LiveNodes& nodes);

/// State topics and TF prefixes of the worlds.
WorldNames worldNamesOf(const LiveRequest& request, const LiveNodes& nodes);

}  // namespace sim2sim
