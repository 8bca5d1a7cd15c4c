// SPDX-License-Identifier: BSD-3-Clause
/// The reference simulator as a node.
#include "pusht_mujoco/mujoco_kind.hpp"
#include "pusht_task/ros/serve.hpp"

int main(int argc, char** argv) { return pusht::serveSimulator(argc, argv, "mujoco", pusht::mujocoKind()); }
