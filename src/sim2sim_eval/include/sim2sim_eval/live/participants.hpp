// SPDX-License-Identifier: BSD-3-Clause
/// What the results of a live run say of the nodes that took part.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "sim2sim_eval/bag/run_bag.hpp"
#include "sim2sim_eval/live/live_nodes.hpp"
#include "sim2sim_eval/live/picture.hpp"
#include "sim2sim_eval/live/request.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"

namespace sim2sim {

/// Throws InvalidInput if the policy of `cast` is not the one that `request` names.
void requirePolicy(const LiveRequest& request, const LiveNodes& nodes);

RunConfiguration configurationOf(const LiveRequest& request, const LiveNodes& nodes);

/// Provenance of the run: that of provenance.json, with the nodes.
nlohmann::ordered_json runProvenance(const RunConfiguration& configuration, const LiveNodes& nodes);

/// The files that the run has read, and its nodes as far as they say so.
std::vector<Input> inputsOf(const LiveRequest& request, const LiveNodes& nodes);

Picture pictureOf(const RunConfiguration& configuration, const LiveNodes& nodes);

/// State topics and TF prefixes of the worlds.
WorldNames worldNamesOf(const LiveRequest& request, const LiveNodes& nodes);

}  // namespace sim2sim
