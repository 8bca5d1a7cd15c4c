// SPDX-License-Identifier: BSD-3-Clause
/// A checkpoint's file, as far as it can be judged without libtorch.
#pragma once

#include <filesystem>
#include <string>

#include "checkpoint_archive.hpp"
#include "pusht_policy/policy_description.hpp"

namespace pusht {

/// Bytes of a checkpoint, verified, and its description. Throws as NetworkPolicy::load().
struct CheckpointFile {
  explicit CheckpointFile(const std::filesystem::path& path);

  std::string name;  ///< for messages
  std::string bytes;
  std::string hash;
  Records records;
  PolicyDescription description;
};

}  // namespace pusht
