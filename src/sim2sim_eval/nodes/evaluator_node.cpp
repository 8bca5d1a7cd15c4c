// SPDX-License-Identifier: BSD-3-Clause
/// The evaluator as a node.
#include "pusht_task/ros/node.hpp"
#include "sim2sim_eval/evaluator.hpp"

int main(int argc, char** argv) { return pusht::runNode(argc, argv, "sim2sim", sim2sim::evaluate); }
