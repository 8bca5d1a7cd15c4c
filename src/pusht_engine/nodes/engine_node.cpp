// SPDX-License-Identifier: BSD-3-Clause
/// The two-mass engine as a node.
#include "pusht_engine/two_mass_kind.hpp"
#include "pusht_task/ros/serve.hpp"

int main(int argc, char** argv) { return pusht::serveSimulator(argc, argv, "engine", pusht::twoMassKind()); }
