// SPDX-License-Identifier: BSD-3-Clause
/// Provenance of a checkpoint, as far as it decides whether the checkpoint is read.
#pragma once

#include <filesystem>
#include <string>

namespace pusht {

/// Compares the hash of a checkpoint with that in the file PATH.provenance.json, if there is one. `name` is for
/// messages. Throws BadDependency if they differ, InvalidInput if that file cannot be read or names no hash.
void requireHashOfProvenance(const std::filesystem::path& path, const std::string& name, const std::string& sha256);

}  // namespace pusht
