// SPDX-License-Identifier: BSD-3-Clause
/// PushT in Chipmunk as a node.
#include "pusht_chipmunk/chipmunk_kind.hpp"
#include "pusht_task/ros/serve.hpp"

int main(int argc, char** argv) { return pusht::serveSimulator(argc, argv, "chipmunk", pusht::chipmunkKind()); }
