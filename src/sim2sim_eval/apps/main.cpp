// SPDX-License-Identifier: BSD-3-Clause
// The main of every command. CMakeLists.txt names its function of the library, such as compareMain.
namespace sim2sim {
int COMMAND_MAIN(int argc, char** argv);
}  // namespace sim2sim

int main(int argc, char** argv) { return sim2sim::COMMAND_MAIN(argc, argv); }
