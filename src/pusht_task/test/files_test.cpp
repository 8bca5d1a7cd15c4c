// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/files.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <iterator>
#include <string>

#include "pusht_task/error.hpp"
#include "pusht_task/testing/temporary_folder.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;

class Files : public ::testing::Test {
 protected:
  std::ptrdiff_t fileCount() const {
    return std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator());
  }

  testing::TemporaryFolder folder_;
};

TEST_F(Files, WriteReplacesAndLeavesNothingAside) {
  writeFile(folder_ / "a", "old");
  writeFile(folder_ / "a", "new");
  EXPECT_EQ(readFile(folder_ / "a", "file"), "new");
  EXPECT_EQ(fileCount(), 1);
}

TEST_F(Files, AFailedWriteKeepsTheOldFile) {
  // /dev/full takes the open and fails the write, as a full disk does.
  writeFile(folder_ / "a", "old");
  fs::create_symlink("/dev/full", asidePath(folder_ / "a"));
  EXPECT_THROW(writeFile(folder_ / "a", "new"), RuntimeFault);
  EXPECT_EQ(readFile(folder_ / "a", "file"), "old");
  EXPECT_EQ(fileCount(), 1);
}

TEST_F(Files, AMissingFolderIsNamed) {
  try {
    writeFile((folder_ / "none") / "a", "x");
    FAIL();
  } catch (const RuntimeFault& fault) {
    EXPECT_NE(std::string(fault.what()).find(((folder_ / "none") / "a").string()), std::string::npos);
  }
}

TEST_F(Files, ReadNamesWhatIsMissing) {
  EXPECT_THROW(readFile(folder_ / "a", "scene"), InvalidInput);
  EXPECT_THROW(readFile(folder_.path(), "scene"), InvalidInput);
}

TEST(Digest, KnownAnswers) {
  // FIPS 180-2, appendix B.1, and RFC 1321, appendix A.5.
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(md5("abc"), "900150983cd24fb0d6963f7d28e17f72");
}

}  // namespace
}  // namespace pusht
