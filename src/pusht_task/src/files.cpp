// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/files.hpp"

#include <fcntl.h>
#include <openssl/evp.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;

/// Writes all of `content` to the open file; false with errno set if that fails.
bool writeAll(int file, const std::string& content) {
  std::size_t written = 0;
  while (written < content.size()) {
    const ssize_t count = ::write(file, content.data() + written, content.size() - written);
    if (count < 0 && errno != EINTR) {
      return false;
    }
    written += count > 0 ? static_cast<std::size_t>(count) : 0;
  }
  return true;
}

void write(const fs::path& path, const std::string& content, bool to_disk) {
  AsideFile file(path);
  file.write(content, to_disk);
  file.moveIntoPlace();
}

std::string digest(const EVP_MD* algorithm, const std::string& bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> hash{};
  unsigned int size = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), hash.data(), &size, algorithm, nullptr) != 1) {
    throw InternalError("the digest of " + std::to_string(bytes.size()) + " bytes failed");
  }
  constexpr const char* kHexDigits = "0123456789abcdef";
  std::string hex;
  for (unsigned int i = 0; i < size; ++i) {
    hex += kHexDigits[hash.at(i) >> 4U];
    hex += kHexDigits[hash.at(i) & 15U];
  }
  return hex;
}

}  // namespace

void requireNewFile(const std::string& what, const fs::path& path) {
  std::error_code ignored;
  if (!path.empty() && fs::symlink_status(path, ignored).type() != fs::file_type::not_found) {
    throw InvalidInput(what + " " + path.string() + ": is there already; name a new file");
  }
}

std::string readFile(const fs::path& path, const std::string& what) {
  std::error_code error;
  std::ifstream file;
  if (fs::is_regular_file(path, error)) {  // asked first: to open a pipe may block for ever
    file.open(path, std::ios::binary);
  }
  if (!file.is_open()) {
    throw InvalidInput(what + " " + path.string() + ": must be a readable file");
  }
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

AsideFile::AsideFile(fs::path path) : path_(std::move(path)) {
  constexpr mode_t kMode = 0644;
  for (int number = 1; descriptor_ < 0; ++number) {
    aside_ = path_.string() + (number == 1 ? "" : "." + std::to_string(number)) + ".part";
    descriptor_ = ::open(aside_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kMode);
    if (descriptor_ < 0 && errno != EEXIST) {
      fail();
    }
  }
}

AsideFile::~AsideFile() {
  ::close(descriptor_);
  if (!aside_.empty()) {
    ::unlink(aside_.c_str());
  }
}

void AsideFile::write(const std::string& content, bool to_disk) {
  if (!writeAll(descriptor_, content) || (to_disk && ::fsync(descriptor_) != 0)) {
    fail();
  }
}

void AsideFile::writeAt(std::size_t offset, const std::string& content) {
  if (::pwrite(descriptor_, content.data(), content.size(), static_cast<off_t>(offset)) !=
      static_cast<ssize_t>(content.size())) {
    fail();
  }
}

void AsideFile::moveIntoPlace() {
  if (std::rename(aside_.c_str(), path_.c_str()) != 0) {
    fail();
  }
  aside_.clear();
}

void AsideFile::fail() const { throw RuntimeFault("cannot write " + path_.string() + ": " + std::strerror(errno)); }

void writeFile(const fs::path& path, const std::string& content) { write(path, content, true); }

void writeCacheFile(const fs::path& path, const std::string& content) { write(path, content, false); }

std::string sha256(const std::string& bytes) { return digest(EVP_sha256(), bytes); }

std::string md5(const std::string& bytes) { return digest(EVP_md5(), bytes); }

}  // namespace pusht
