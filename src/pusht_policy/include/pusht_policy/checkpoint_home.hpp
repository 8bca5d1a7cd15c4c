// SPDX-License-Identifier: BSD-3-Clause
/// Home of a checkpoint: the simulator in which its demonstrations took place.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace pusht {

/// Simulator of demonstrations.
struct CheckpointHome {
  std::string simulator;                ///< kind
  std::vector<std::string> settings{};  ///< "NAME=VALUE": the parameters that did not have their defaults
};

/// File beside a checkpoint that says where it comes from: PATH.provenance.json.
inline std::filesystem::path provenancePath(const std::filesystem::path& checkpoint) {
  return checkpoint.string() + ".provenance.json";
}

/// Home that the provenance of a checkpoint names. Of demonstrations in several simulators it is the first one;
/// parameters that were drawn for each demonstration have their defaults. Throws InvalidInput, naming the file, if
/// there is no provenance, it names no simulator, or the simulator has a file of its own as a parameter.
CheckpointHome homeOf(const std::filesystem::path& checkpoint);

}  // namespace pusht
