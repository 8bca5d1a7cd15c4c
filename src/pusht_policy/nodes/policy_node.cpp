// SPDX-License-Identifier: BSD-3-Clause
/// A policy as a node.
#include <ros/console.h>
#include <ros/init.h>

#include <utility>

#include "pusht_policy/policy_choice.hpp"
#include "sim2sim_serving/installed_file.hpp"
#include "sim2sim_serving/serve.hpp"

namespace {

pusht::PolicyModel load(pusht::ParameterReader& parameters) {
  pusht::PolicyChoice choice;
  choice.policy = parameters.text("policy", choice.policy);
  choice.require_policy = parameters.flag("require_policy", choice.require_policy);
  choice.allow_untrained = parameters.flag("allow_untrained", choice.allow_untrained);
  choice.untrained_seed = parameters.seed("seed", choice.untrained_seed);
  choice.task = pusht::taskNamed(parameters.text(pusht::kTaskParameter, choice.task.get().name));
  pusht::ChosenPolicy chosen = pusht::choosePolicy(
      choice, pusht::installedFile("pusht_policy", pusht::kShippedCheckpoint), [] { return !ros::ok(); });
  if (!chosen.warning.empty()) {
    ROS_WARN_STREAM(chosen.warning);
  }
  pusht::PolicyModel model;
  model.name = std::move(chosen.name);
  model.version = PUSHT_POLICY_VERSION;
  model.policy = chosen.make();
  model.task = choice.task;
  model.provenance = std::move(chosen.provenance);
  return model;
}

}  // namespace

int main(int argc, char** argv) { return pusht::servePolicy(argc, argv, "policy", load); }
