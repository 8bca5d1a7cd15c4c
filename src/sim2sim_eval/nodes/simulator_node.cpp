// SPDX-License-Identifier: BSD-3-Clause
/// Any kind of simulator as a node, by name; it can become another one.
#include "sim2sim_serving/serve_simulator.hpp"

int main(int argc, char** argv) { return pusht::serveAnySimulator(argc, argv, "simulator"); }
