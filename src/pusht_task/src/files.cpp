// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/files.hpp"

#include <fcntl.h>
#include <openssl/evp.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <random>
#include <sstream>
#include <system_error>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void failToWrite(const fs::path& path, int error_number) {
  throw RuntimeFault("cannot write " + path.string() + ": " + std::strerror(error_number));
}

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

void write(const fs::path& path, const fs::path& aside, const std::string& content, bool to_disk) {
  constexpr mode_t kMode = 0644;
  const int file = ::open(aside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kMode);
  if (file < 0) {
    failToWrite(path, errno);
  }
  const bool written = writeAll(file, content) && (!to_disk || ::fsync(file) == 0);
  const int error_number = errno;
  ::close(file);
  if (!written) {
    ::unlink(aside.c_str());
    failToWrite(path, error_number);
  }
  moveIntoPlace(aside, path);
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

fs::path asidePath(const fs::path& path) {
  fs::path aside = path;
  aside += ".part";
  return aside;
}

void moveIntoPlace(const fs::path& aside, const fs::path& path) {
  if (std::rename(aside.c_str(), path.c_str()) != 0) {
    const int error_number = errno;
    ::unlink(aside.c_str());
    failToWrite(path, error_number);
  }
}

void writeFile(const fs::path& path, const std::string& content) { write(path, asidePath(path), content, true); }

void writeCacheFile(const fs::path& path, const std::string& content) {
  write(path, asidePath(path.string() + "." + std::to_string(std::random_device()())), content, false);
}

std::string sha256(const std::string& bytes) { return digest(EVP_sha256(), bytes); }

std::string md5(const std::string& bytes) { return digest(EVP_md5(), bytes); }

}  // namespace pusht
