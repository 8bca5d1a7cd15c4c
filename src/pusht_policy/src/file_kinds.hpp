// SPDX-License-Identifier: BSD-3-Clause
/// What files are that people take for TorchScript.
#pragma once

#include <filesystem>
#include <string>

namespace pusht {

/// Throws InvalidInput for a folder, saying what in it could be exported.
void requireFile(const std::filesystem::path& path, const std::string& name);

/// Throws InvalidInput for the bytes of another known format, saying what it is and how to export it. `name` is that of
/// the policy, for messages.
void requireNoOtherFormat(const std::string& bytes, const std::string& name);

}  // namespace pusht
