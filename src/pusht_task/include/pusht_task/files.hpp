// SPDX-License-Identifier: BSD-3-Clause
/// Files that are complete or absent, and their fingerprints.
#pragma once

#include <filesystem>
#include <string>

namespace pusht {

/// The bytes of `path`. Throws InvalidInput, naming `what` and the path, if it cannot be read.
std::string readFile(const std::filesystem::path& path, const std::string& what);

/// Where a file is written before it is complete; beside `path`, so that a rename moves it there.
std::filesystem::path asidePath(const std::filesystem::path& path);

/// Puts the complete file at `aside` in place of `path`. Throws RuntimeFault and removes `aside` on failure.
void moveIntoPlace(const std::filesystem::path& aside, const std::filesystem::path& path);

/// Writes `content` aside, to the disk, and renames it: `path` holds the old bytes or all the new ones.
/// Throws RuntimeFault if that fails (disk full, folder not writable); nothing is left behind.
void writeFile(const std::filesystem::path& path, const std::string& content);

/// The same for what can be made again: it is not forced onto the disk, and several processes may write one file.
void writeCacheFile(const std::filesystem::path& path, const std::string& content);

/// Digest in lower-case hex.
std::string sha256(const std::string& bytes);
std::string md5(const std::string& bytes);

}  // namespace pusht
