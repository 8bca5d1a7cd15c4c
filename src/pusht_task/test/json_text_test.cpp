// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/json_text.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

namespace pusht {
namespace {

std::string nested(std::size_t levels) { return std::string(levels, '[') + std::string(levels, ']'); }

TEST(JsonTexts, AreReadAsTheyStand) {
  EXPECT_EQ(parseJson(R"({"a": [1, 2.5, "x", null]})"), (nlohmann::json{{"a", {1, 2.5, "x", nullptr}}}));
}

TEST(JsonTexts, AreDiscardedIfTheyAreNone) {
  for (const char* text : {"", "{", "{\"a\": 1e400}", "[1] 2", "\xff"}) {
    EXPECT_TRUE(parseJson(text).is_discarded()) << text;
  }
}

TEST(JsonTexts, AreDiscardedIfTheyAreNestedTooDeeply) {
  EXPECT_TRUE(parseJson(nested(100)).is_array());
  EXPECT_TRUE(parseJson("[" + nested(100) + "]").is_discarded());
  EXPECT_TRUE(parseJson(nested(101)).is_discarded());
  EXPECT_TRUE(parseJson(nested(1'000'000)).is_discarded());
}

}  // namespace
}  // namespace pusht
