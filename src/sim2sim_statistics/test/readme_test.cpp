// SPDX-License-Identifier: BSD-3-Clause
/// The example of the README is that of examples/, and prints what the README says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

namespace sim2sim {
namespace {

std::string read(const std::string& name) {
  std::ifstream file(STATISTICS_PACKAGE "/" + name);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string outputOfExample() {
  // NOLINTNEXTLINE(cert-env33-c): every word of it is ours
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(TWO_POLICIES, "r"), pclose);
  std::string output;
  std::array<char, 200> line{};
  while (pipe != nullptr && fgets(line.data(), line.size(), pipe.get()) != nullptr) {
    output += line.data();
  }
  return output;
}

TEST(Readme, ShowsTheExampleAndItsOutput) {
  const std::string source = read("examples/two_policies.cpp");
  const std::string shown = source.substr(source.find('\n') + 1);  // without the license
  EXPECT_THAT(read("README.md"), testing::HasSubstr("```cpp\n" + shown + "```\n"));
  const std::string output = outputOfExample();
  EXPECT_THAT(output, testing::HasSubstr("new - old"));
  EXPECT_THAT(read("README.md"), testing::HasSubstr("```\n" + output + "```\n"));
}

}  // namespace
}  // namespace sim2sim
