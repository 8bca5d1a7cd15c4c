// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/files.hpp"

#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <memory>
#include <string_view>
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

/// Reads a plain file of at most so many bytes and passes them on, piece by piece. Throws as readFile().
template <class Take>
void readPieces(const fs::path& path, const std::string& what, std::size_t most, const Take& take) {
  constexpr std::size_t kPiece = 1U << 20U;
  const std::string name = what + " " + path.string();
  std::error_code error;
  struct stat status {};
  // Asked first: opening a device may do something. (And what takes its place meanwhile must not block.)
  const int file = fs::is_regular_file(path, error) ? ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK) : -1;
  const auto close = [](const int* open) { ::close(*open); };
  const std::unique_ptr<const int, decltype(close)> closing(file < 0 ? nullptr : &file, close);
  if (file < 0 || ::fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) {
    throw InvalidInput(name + ": must be a readable file");
  }
  const auto require_few = [&](std::size_t count) {
    if (count > most) {
      throw InvalidInput(name + ": has " + std::to_string(count) + " bytes, must have at most " + std::to_string(most));
    }
  };
  require_few(static_cast<std::size_t>(status.st_size));
  std::string piece(kPiece, '\0');
  std::size_t bytes = 0;
  for (ssize_t count = 1; count != 0;) {
    count = ::read(file, piece.data(), piece.size());
    if (count < 0 && errno != EINTR) {
      throw RuntimeFault("cannot read " + name + ": " + std::strerror(errno));
    }
    bytes += count > 0 ? static_cast<std::size_t>(count) : 0;
    require_few(bytes);  // it may grow
    take(std::string_view(piece).substr(0, count > 0 ? static_cast<std::size_t>(count) : 0));
  }
  const bool has_size = status.st_size != 0;  // what the kernel makes as it is read has none
  if (::fstat(file, &status) == 0 && (has_size || status.st_size != 0) &&
      static_cast<std::size_t>(status.st_size) != bytes) {
    throw RuntimeFault("cannot read " + name + ": it has " + std::to_string(status.st_size) + " bytes, but " +
                       std::to_string(bytes) + " were read; it must not change meanwhile");
  }
}

class Digest {
 public:
  explicit Digest(const EVP_MD* algorithm) { require(EVP_DigestInit_ex(context_.get(), algorithm, nullptr)); }

  void add(std::string_view bytes) { require(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size())); }

  std::string hex() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> hash{};
    unsigned int size = 0;
    require(EVP_DigestFinal_ex(context_.get(), hash.data(), &size));
    constexpr const char* kHexDigits = "0123456789abcdef";
    std::string hex;
    for (unsigned int i = 0; i < size; ++i) {
      hex += kHexDigits[hash.at(i) >> 4U];
      hex += kHexDigits[hash.at(i) & 15U];
    }
    return hex;
  }

 private:
  static void require(int succeeded) {
    if (succeeded != 1) {
      throw InternalError("OpenSSL: a digest failed");
    }
  }

  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_{EVP_MD_CTX_new(), &EVP_MD_CTX_free};
};

std::string digest(const EVP_MD* algorithm, const std::string& bytes) {
  Digest digest(algorithm);
  digest.add(bytes);
  return digest.hex();
}

}  // namespace

void requireNewFile(const std::string& what, const fs::path& path) {
  std::error_code ignored;
  if (!path.empty() && fs::symlink_status(path, ignored).type() != fs::file_type::not_found) {
    throw InvalidInput(what + " " + path.string() + ": is there already; name a new file");
  }
}

std::string readFile(const fs::path& path, const std::string& what, std::size_t most) {
  std::string bytes;
  readPieces(path, what, most, [&](std::string_view piece) { bytes += piece; });
  return bytes;
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

void AsideFile::moveIntoNewPlace(const std::string& what) {
  if (::renameat2(AT_FDCWD, aside_.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE) == 0) {
    aside_.clear();
    return;
  }
  // A file system that cannot do this may link: that does not replace either, and leaves the file aside to be removed.
  if (errno == EINVAL && ::link(aside_.c_str(), path_.c_str()) == 0) {
    return;
  }
  if (errno == EEXIST) {
    throw RuntimeFault(what + " " + path_.string() + ": has come there meanwhile; it stays, and nothing is written");
  }
  fail();
}

void AsideFile::fail() const { throw RuntimeFault("cannot write " + path_.string() + ": " + std::strerror(errno)); }

void writeFile(const fs::path& path, const std::string& content) { write(path, content, true); }

void writeNewFile(const std::string& what, const fs::path& path, const std::string& content) {
  AsideFile file(path);
  file.write(content, true);
  file.moveIntoNewPlace(what);
}

void writeCacheFile(const fs::path& path, const std::string& content) { write(path, content, false); }

std::string sha256(const std::string& bytes) { return digest(EVP_sha256(), bytes); }

std::string sha256OfFile(const fs::path& path, const std::string& what) {
  Digest digest(EVP_sha256());
  readPieces(path, what, std::numeric_limits<std::size_t>::max(), [&](std::string_view piece) { digest.add(piece); });
  return digest.hex();
}

std::string md5(const std::string& bytes) { return digest(EVP_md5(), bytes); }

}  // namespace pusht
