// SPDX-License-Identifier: BSD-3-Clause
// Preloaded in a test: a disk fails. Reading a file fails after ten bytes if its name ends in what the environment
// variable FAIL_TO_READ says.
#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {

constexpr off_t kReadable = 10;  // bytes

/// Whether the next bytes of an open file cannot be read.
bool fails(int file, off_t at) {
  const char* const end = std::getenv("FAIL_TO_READ");
  std::array<char, 4096> name{};
  const std::string link = "/proc/self/fd/" + std::to_string(file);
  const ssize_t length = end == nullptr ? -1 : ::readlink(link.c_str(), name.data(), name.size());
  if (length < 0) {
    return false;
  }
  const std::string_view path(name.data(), static_cast<std::size_t>(length));
  const std::string_view ending(end);
  return at >= kReadable && path.size() >= ending.size() && path.substr(path.size() - ending.size()) == ending;
}

template <class Function>
Function* original(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" ssize_t read(int file, void* bytes, std::size_t count) {
  const off_t at = ::lseek(file, 0, SEEK_CUR);
  if (fails(file, at)) {
    errno = EIO;
    return -1;
  }
  const std::size_t readable = fails(file, kReadable) && at >= 0 ? static_cast<std::size_t>(kReadable - at) : count;
  return original<decltype(::read)>("read")(file, bytes, std::min(count, readable));
}

/// What rosbag calls. The library of C reads by itself below it.
extern "C" std::size_t fread(void* bytes, std::size_t size, std::size_t count, FILE* stream) {
  if (fails(::fileno(stream), ::ftello(stream))) {
    errno = EIO;
    return 0;
  }
  return original<decltype(::fread)>("fread")(bytes, size, count, stream);
}
