// SPDX-License-Identifier: BSD-3-Clause
/// Damaged checkpoints without a provenance file beside them: refused in one line, or the same policy still.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zip.h>

#include <filesystem>
#include <functional>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "../src/checkpoint_archive.hpp"
#include "network_testing.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/long_tests.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;
using testing::act;
using testing::bits;
using testing::flatten;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::observations;

const int kMutationsOfAKind = testing::longTests() ? 60 : 20;

/// The shipped checkpoint, alone.
class DamagedCheckpoint : public ::testing::Test {
 protected:
  DamagedCheckpoint() { writeFile(path_, whole_); }

  std::size_t below(std::size_t bound) {
    return static_cast<std::size_t>(generator_.uniform(0, static_cast<double>(bound)));
  }

  /// A byte at or after `first` in `bytes`, with other bits.
  std::string flipped(std::string bytes, std::size_t first = 0) {
    char& byte = bytes[first + below(bytes.size() - first)];
    byte = static_cast<char>(byte ^ static_cast<char>(1 + below(255)));
    return bytes;
  }

  std::string anyRecord() { return std::next(records_.begin(), static_cast<std::ptrdiff_t>(below(18)))->first; }

  /// The checkpoint with other content in one record; everything else about the archive fits it.
  std::string withRecord(const std::string& record, const std::string& content) {
    const fs::path rewritten = folder_ / "rewritten.zip";
    writeFile(rewritten, whole_);
    zip_t* const archive = zip_open(rewritten.c_str(), 0, nullptr);
    zip_source_t* const source = zip_source_buffer(archive, content.data(), content.size(), 0);
    const zip_int64_t index = zip_file_add(archive, record.c_str(), source, ZIP_FL_OVERWRITE);
    if (index < 0 || zip_set_file_compression(archive, static_cast<zip_uint64_t>(index), ZIP_CM_STORE, 0) != 0 ||
        zip_close(archive) != 0) {
      throw std::runtime_error("cannot write record " + record);
    }
    return readFile(rewritten, "archive");
  }

  /// What the checkpoint's policy does, or why it is refused.
  std::string outcomeOf(const std::string& bytes) {
    writeFile(path_, bytes);
    try {
      const auto policy = NetworkPolicy::load(path_);
      const std::vector<std::uint32_t> actions = bits(flatten(act(*policy, observations())));
      return actions == expected_ ? kSame : "other actions";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
      EXPECT_THAT(error.what(), HasSubstr(path_.string()));
      EXPECT_TRUE(error.exitCode() == ExitCode::kInvalidInput || error.exitCode() == ExitCode::kBadDependency)
          << error.what();
      return error.what();
    }
  }

  /// How many of the mutations are refused; the others must act as the checkpoint does. Other mutations than those
  /// that a crash would end with this process.
  int refused(const std::function<std::string()>& mutate) {
    int count = 0;
    for (int i = 0; i < kMutationsOfAKind; ++i) {
      const std::string bytes = mutate();
      const std::string outcome = outcomeOf(bytes);
      EXPECT_NE(outcome, "other actions") << "mutation " << i;
      count += outcome != kSame ? 1 : 0;
    }
    std::cout << count << " of " << kMutationsOfAKind << " refused, the others act as before" << std::endl;
    return count;
  }

  static constexpr const char* kSame = "same actions";

  const testing::TemporaryFolder folder_;
  const fs::path path_ = folder_ / "policy.ts.pt";
  const fs::path shipped_ = fs::path(PUSHT_POLICIES_DIR) / "bc_policy.ts.pt";
  const std::string whole_ = readFile(shipped_, "policy");
  const Records records_ = verifiedRecords(whole_, "shipped");
  const std::vector<std::uint32_t> expected_ = bits(flatten(act(*NetworkPolicy::load(shipped_), observations())));
  NumpyGenerator generator_{20000};
};

TEST_F(DamagedCheckpoint, WithAnotherByteIsRefusedOrTheSame) {
  // Records fill nearly all of the file; in 60 bytes, one or two may lie in names or dates that decide nothing.
  EXPECT_GT(refused([&] { return flipped(whole_); }), kMutationsOfAKind - 5);
}

TEST_F(DamagedCheckpoint, WithAnotherByteInItsDirectoryIsRefusedOrTheSame) {
  const std::size_t directory = whole_.find("PK\1\2");
  EXPECT_GT(refused([&] { return flipped(whole_, directory); }), kMutationsOfAKind / 2);
}

TEST_F(DamagedCheckpoint, CutOffIsRefused) {
  EXPECT_EQ(refused([&] { return whole_.substr(0, below(whole_.size())); }), kMutationsOfAKind);
}

TEST_F(DamagedCheckpoint, WithAnEmptyRecordIsRefused) {
  EXPECT_EQ(refused([&] { return withRecord(anyRecord(), ""); }), kMutationsOfAKind);
}

TEST_F(DamagedCheckpoint, WithAShortRecordIsRefusedOrTheSame) {
  // Code without its last line break is the same code.
  EXPECT_GT(refused([&] {
              const std::string record = anyRecord();
              return withRecord(record, records_.at(record).substr(0, below(records_.at(record).size())));
            }),
            kMutationsOfAKind - 5);
}

/// Any bytes are a legitimate pickle if they are one, perhaps of another policy: nothing may crash.
TEST_F(DamagedCheckpoint, WithAnotherPickleNeverCrashes) {
  for (int i = 0; i < kMutationsOfAKind; ++i) {
    const std::string record = i % 6 == 0 ? "archive/constants.pkl" : "archive/data.pkl";
    outcomeOf(withRecord(record, flipped(records_.at(record))));
  }
}

TEST_F(DamagedCheckpoint, IsRefusedByRecordAndRule) {
  std::string bytes = whole_;
  bytes[whole_.find(records_.at("archive/data/6").substr(0, 64)) + 1000] ^= 1;
  EXPECT_THAT(outcomeOf(bytes), HasSubstr(": record archive/data/6: must have the size and the CRC-32 that the "
                                          "archive names, but is damaged"));
  for (const std::size_t size : {0, 39}) {
    EXPECT_THAT(
        outcomeOf(withRecord("archive/data/0", records_.at("archive/data/0").substr(0, size))),
        HasSubstr(": record archive/data/0: must have the 40 bytes of its tensor, but has " + std::to_string(size)));
  }
  EXPECT_THAT(outcomeOf(withRecord("archive/data/0", records_.at("archive/data/0") + "x")),
              HasSubstr("must have the 40 bytes of its tensor, but has 41"));
  EXPECT_EQ(outcomeOf(whole_), kSame);
}

/// libtorch takes the mark of a folder for a reason not to read the record.
TEST_F(DamagedCheckpoint, WithARecordThatCallsItselfAFolderIsRefused) {
  constexpr std::size_t kExternalAttributes = 38;  // in an entry of the directory
  std::string bytes = whole_;
  bytes[whole_.find("PK\1\2") + kExternalAttributes] ^= 0x10;
  EXPECT_THAT(outcomeOf(bytes), HasSubstr("libtorch must find the archive's bytes, but finds others"));
}

/// A tensor that is larger than its record: a pickle that asks for 513 columns of 512.
TEST_F(DamagedCheckpoint, WithATensorBeyondItsRecordIsRefused) {
  std::string pickle = records_.at("archive/data.pkl");
  const std::string sizes("M\0\2K\n", 5);  // 512, 10: the first layer's shape
  const std::size_t shape = pickle.find(sizes);
  ASSERT_NE(shape, std::string::npos);
  pickle[shape + 1] = 1;
  EXPECT_THAT(outcomeOf(withRecord("archive/data.pkl", pickle)),
              HasSubstr(": record archive/data/4: must hold all elements of its tensor, but has 20480 bytes"));
}

}  // namespace
}  // namespace pusht
