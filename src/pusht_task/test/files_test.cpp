// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/files.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <string>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;

/// No file of the process may grow beyond `bytes` for as long as the object lives.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit = {bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit before_{};
};

class Files : public ::testing::Test {
 protected:
  Files() { fs::create_directories(folder_); }
  ~Files() override { fs::remove_all(folder_); }

  std::ptrdiff_t fileCount() const { return std::distance(fs::directory_iterator(folder_), fs::directory_iterator()); }

  const fs::path folder_ = fs::path(::testing::TempDir()) / ("pusht_files_" + std::to_string(getpid()));
};

TEST_F(Files, WriteReplacesAndLeavesNothingAside) {
  writeFile(folder_ / "a", "old");
  writeFile(folder_ / "a", "new");
  EXPECT_EQ(readFile(folder_ / "a", "file"), "new");
  EXPECT_EQ(fileCount(), 1);
}

TEST_F(Files, AFailedWriteKeepsTheOldFile) {
  writeFile(folder_ / "a", "old");
  {
    const FileSizeLimit as_a_full_disk(2);
    EXPECT_THROW(writeFile(folder_ / "a", "new"), RuntimeFault);
  }
  EXPECT_EQ(readFile(folder_ / "a", "file"), "old");
  EXPECT_EQ(fileCount(), 1);
}

TEST_F(Files, WhatLiesUnderTheNameAsideIsNotTouched) {
  writeFile(folder_ / "mine", "mine");
  fs::create_symlink(folder_ / "mine", folder_ / "a.part");
  writeFile(folder_ / "a.2.part", "mine too");
  fs::create_directory(folder_ / "a.3.part");
  writeFile(folder_ / "a", "new");
  writeCacheFile(folder_ / "a", "newer");
  EXPECT_EQ(readFile(folder_ / "a", "file"), "newer");
  EXPECT_EQ(readFile(folder_ / "a.part", "link"), "mine");
  EXPECT_EQ(readFile(folder_ / "a.2.part", "file"), "mine too");
  EXPECT_EQ(fileCount(), 5);
}

TEST_F(Files, ALinkIsReplacedAndNotFollowed) {
  writeFile(folder_ / "mine", "mine");
  fs::create_symlink(folder_ / "mine", folder_ / "a");
  writeFile(folder_ / "a", "new");
  EXPECT_EQ(readFile(folder_ / "mine", "file"), "mine");
  EXPECT_FALSE(fs::is_symlink(folder_ / "a"));
}

TEST_F(Files, ANewFileReplacesNothingThatHasComeMeanwhile) {
  AsideFile file(folder_ / "a");
  file.write("mine", false);
  writeNewFile("out", folder_ / "a", "theirs");
  try {
    file.moveIntoNewPlace("out");
    FAIL();
  } catch (const RuntimeFault& fault) {
    EXPECT_EQ(fault.what(),
              "out " + (folder_ / "a").string() + ": has come there meanwhile; it stays, and nothing is written");
  }
  EXPECT_EQ(readFile(folder_ / "a", "file"), "theirs");
  EXPECT_THROW(writeNewFile("out", folder_ / "a", "mine"), RuntimeFault);
  EXPECT_EQ(readFile(folder_ / "a", "file"), "theirs");
}

TEST_F(Files, AFileThatIsNotMovedLeavesNothing) {
  {
    AsideFile file(folder_ / "a");
    file.write("half", false);
    EXPECT_EQ(readFile(folder_ / "a.part", "file"), "half");
  }
  EXPECT_EQ(fileCount(), 0);
}

TEST_F(Files, AMissingFolderIsNamed) {
  try {
    writeFile((folder_ / "none") / "a", "x");
    FAIL();
  } catch (const RuntimeFault& fault) {
    EXPECT_NE(std::string(fault.what()).find(((folder_ / "none") / "a").string()), std::string::npos);
  }
}

TEST_F(Files, ReadIsWholeOrAFault) {
  constexpr std::size_t kMoreThanIsReadAtOnce = 2'500'000;
  const std::string whole(kMoreThanIsReadAtOnce, 'x');
  writeFile(folder_ / "a", whole);
  EXPECT_EQ(readFile(folder_ / "a", "file"), whole);
  EXPECT_EQ(sha256OfFile(folder_ / "a", "file"), sha256(whole));
  try {
    readFile("/proc/self/mem", "memory");  // whose first page cannot be read
    FAIL();
  } catch (const RuntimeFault& fault) {
    EXPECT_STREQ(fault.what(), "cannot read memory /proc/self/mem: Input/output error");
  }
}

TEST_F(Files, ReadNamesWhatIsMissingOrTooLarge) {
  EXPECT_THROW(readFile(folder_ / "a", "scene"), InvalidInput);
  EXPECT_THROW(readFile(folder_, "scene"), InvalidInput);
  writeFile(folder_ / "b", "12345");
  EXPECT_EQ(readFile(folder_ / "b", "scene", 5), "12345");
  try {
    readFile(folder_ / "b", "scene", 4);
    FAIL();
  } catch (const InvalidInput& refusal) {
    EXPECT_EQ(refusal.what(), "scene " + (folder_ / "b").string() + ": has 5 bytes, must have at most 4");
  }
}

TEST(Digest, KnownAnswers) {
  // FIPS 180-2, appendix B.1, and RFC 1321, appendix A.5.
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(md5("abc"), "900150983cd24fb0d6963f7d28e17f72");
}

}  // namespace
}  // namespace pusht
