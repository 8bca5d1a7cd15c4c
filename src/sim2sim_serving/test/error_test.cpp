// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/error.hpp"

#include <gtest/gtest.h>

#include <new>
#include <stdexcept>
#include <string>

#include "pusht_task/clipped.hpp"
#include "sim2sim_serving/node.hpp"

namespace pusht {
namespace {

/// What is on stderr after reportFailure(), and its exit code.
std::string reported(const std::exception& failure) {
  ::testing::internal::CaptureStderr();
  const int code = reportFailure("compare", failure);
  return std::to_string(code) + " " + ::testing::internal::GetCapturedStderr();
}

TEST(ReportFailure, IsOneLineAndTheExitCodeOfTheKind) {
  EXPECT_EQ(reported(InvalidInput("seed x: must be\na number")), "2 compare: seed x: must be a number\n");
  EXPECT_EQ(reported(RuntimeFault("disk full")), "4 compare: disk full\n");
  EXPECT_EQ(reported(std::logic_error("a defect")), "70 compare: a defect\n");
}

TEST(ReportFailure, MemoryThatIsUsedUpIsAFaultOfTheRun) {
  EXPECT_EQ(reported(std::bad_alloc()), "4 compare: there is no more memory; ask for fewer threads or episodes\n");
}

TEST(ReportFailure, DoesNotEchoLongTexts) {
  EXPECT_LT(reported(InvalidInput("seed '" + std::string(10'000'000, 'x') + "': must be a number")).size(), 2200U);
}

TEST(Clipped, KeepsBeginAndEnd) {
  EXPECT_EQ(clipped("seed 3", 6), "seed 3");
  EXPECT_EQ(clipped("0123456789", 6), "012 ... (4 bytes left out) ... 789");
  EXPECT_EQ(clipped("12\u00e9456\u00e989", 6), "12 ... (7 bytes left out) ... 89") << "UTF-8 stays whole";
}

}  // namespace
}  // namespace pusht
