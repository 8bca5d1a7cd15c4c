// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/files.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;

class Files : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "pusht_files_XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
};

TEST_F(Files, WriteReplacesAndLeavesNothingAside) {
  writeFile(folder_ / "a", "old");
  writeFile(folder_ / "a", "new");
  EXPECT_EQ(readFile(folder_ / "a", "file"), "new");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(Files, AFailedWriteKeepsTheOldFile) {
  // /dev/full takes the open and fails the write, as a full disk does.
  writeFile(folder_ / "a", "old");
  fs::create_symlink("/dev/full", asidePath(folder_ / "a"));
  EXPECT_THROW(writeFile(folder_ / "a", "new"), RuntimeFault);
  EXPECT_EQ(readFile(folder_ / "a", "file"), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(Files, AMissingFolderIsNamed) {
  try {
    writeFile(folder_ / "none" / "a", "x");
    FAIL();
  } catch (const RuntimeFault& fault) {
    EXPECT_NE(std::string(fault.what()).find((folder_ / "none" / "a").string()), std::string::npos);
  }
}

TEST_F(Files, ReadNamesWhatIsMissing) {
  EXPECT_THROW(readFile(folder_ / "a", "scene"), InvalidInput);
  EXPECT_THROW(readFile(folder_, "scene"), InvalidInput);
}

TEST(Digest, KnownAnswers) {
  // FIPS 180-2, appendix B.1, and RFC 1321, appendix A.5.
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(md5("abc"), "900150983cd24fb0d6963f7d28e17f72");
}

}  // namespace
}  // namespace pusht
