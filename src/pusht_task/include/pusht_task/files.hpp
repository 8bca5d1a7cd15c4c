// SPDX-License-Identifier: BSD-3-Clause
/// Files that are complete or absent, and their fingerprints.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace pusht {

constexpr std::size_t kLargestFile = 1U << 30U;       // bytes of a file that is read at once
constexpr std::size_t kLargestSmallFile = 1U << 24U;  // bytes of a plan, scene, provenance, status or verdict

/// The bytes of `path`, all of them. Throws, naming `what` and the path, InvalidInput if it is no plain file that can
/// be opened or has more than `most` bytes, RuntimeFault if reading fails or if the file changes meanwhile.
std::string readFile(const std::filesystem::path& path, const std::string& what, std::size_t most = kLargestFile);

/// Throws InvalidInput, with `what` in front, if there is something at `path`. An empty path passes.
void requireNewFile(const std::string& what, const std::filesystem::path& path);

/// A file that is written beside its `path` until it is complete. It is new: what lies under its name already is
/// neither written to nor followed.
class AsideFile {
 public:
  /// Creates PATH.part, or PATH.2.part, PATH.3.part, ... where there is such a thing. Throws RuntimeFault if it cannot.
  explicit AsideFile(std::filesystem::path path);
  AsideFile(const AsideFile&) = delete;
  AsideFile& operator=(const AsideFile&) = delete;

  /// Removes the file unless it has been moved.
  ~AsideFile();

  const std::filesystem::path& aside() const { return aside_; }

  /// Throws RuntimeFault if that fails. `to_disk`: returns when the disk has it.
  void write(const std::string& content, bool to_disk);

  /// Writes over what stands `offset` bytes from the begin. Throws RuntimeFault if that fails.
  void writeAt(std::size_t offset, const std::string& content);

  /// Puts the file in place of `path`. Throws RuntimeFault if that fails.
  void moveIntoPlace();

  /// Puts the file at `path`. Throws RuntimeFault, with `what` in front, if there is something by now, or if that
  /// fails.
  void moveIntoNewPlace(const std::string& what);

 private:
  [[noreturn]] void fail() const;

  std::filesystem::path path_;
  std::filesystem::path aside_;  // empty: moved
  int descriptor_ = -1;
};

/// Writes `content` aside, to the disk, and renames it: `path` holds the old bytes or all the new ones.
/// Throws RuntimeFault if that fails (disk full, folder not writable); nothing is left behind.
void writeFile(const std::filesystem::path& path, const std::string& content);

/// Likewise, at a `path` where nothing is. Throws RuntimeFault, with `what` in front, if there is something by then.
void writeNewFile(const std::string& what, const std::filesystem::path& path, const std::string& content);

/// Writes `content` aside and renames it, without waiting for the disk; for files that can be made again. Several
/// processes may write one file.
void writeCacheFile(const std::filesystem::path& path, const std::string& content);

/// Digest in lower-case hex.
std::string sha256(const std::string& bytes);
/// Digest of a file that may be large. Throws as readFile().
std::string sha256OfFile(const std::filesystem::path& path, const std::string& what);
/// MD5 digest in lower-case hex.
std::string md5(const std::string& bytes);

}  // namespace pusht
