// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/audit_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_testing/temporary_folder.hpp"
#include "sim2sim_protocol/reference_cache.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Optional;

const nlohmann::json kPair = {{"engine", "one"}};

class KeptVerdictTest : public ::testing::Test {
 protected:
  fs::path file(const nlohmann::json& key = kPair) const { return audits() / (keptName(key) + ".json"); }
  fs::path audits() const { return folder_.path() / "results" / "audits"; }

  /// What find() says of the file after a change to its text.
  std::string refusalAfter(const std::function<void(std::string&)>& change) {
    verdict_.keep({"delay of actions"});
    std::string text = pusht::readFile(file(), "file");
    change(text);
    pusht::writeFile(file(), text);
    try {
      verdict_.find();
      return "";
    } catch (const pusht::BadDependency& error) {
      return error.what();
    }
  }

  pusht::testing::TemporaryFolder folder_;
  KeptVerdict verdict_{audits(), kPair};
};

TEST_F(KeptVerdictTest, IsThatOfTheLastAuditOfThePair) {
  EXPECT_FALSE(verdict_.find());
  verdict_.keep({"delay of actions", "noise"});
  EXPECT_THAT(KeptVerdict(audits(), kPair).find(), Optional(ElementsAre("delay of actions", "noise")));
  EXPECT_FALSE(KeptVerdict(audits(), {{"engine", "another"}}).find());
  verdict_.keep({});
  EXPECT_THAT(verdict_.find(), Optional(IsEmpty()));
}

TEST_F(KeptVerdictTest, IsRefusedByNameIfItIsDamaged) {
  const auto replace = [](const char* old, const char* other) {
    return [=](std::string& text) { text.replace(text.find(old), std::string(old).size(), other); };
  };
  const std::string name = file().filename();
  EXPECT_THAT(refusalAfter(replace("delay", "decay")), HasSubstr(name + ": is damaged"));
  EXPECT_THAT(refusalAfter(replace("\"delay of actions\"", "7")), HasSubstr(name + ": is damaged"));
  EXPECT_THAT(refusalAfter(replace("contract_errors", "other")), HasSubstr(name + ": is damaged"));
  EXPECT_THAT(refusalAfter([](std::string& text) { text.resize(text.size() / 2); }), HasSubstr("must be an"));
  EXPECT_THAT(refusalAfter([](std::string& text) { text.clear(); }), HasSubstr("must be an"));
  EXPECT_THAT(refusalAfter([](std::string& text) { text = "[1]"; }), HasSubstr("must be an"));
  EXPECT_THAT(refusalAfter(replace("audit verdict 1", "audit verdict 99")),
              HasSubstr("format \"audit verdict 99\": must be \"audit verdict 1\"; another version of the suite wrote "
                        "it; delete it"));
}

TEST_F(KeptVerdictTest, OfAnotherPairIsRefused) {
  const nlohmann::json other = {{"engine", "another"}};
  KeptVerdict(audits(), other).keep({});
  fs::copy_file(file(other), file());
  try {
    verdict_.find();
    FAIL() << "is not refused";
  } catch (const pusht::BadDependency& error) {
    EXPECT_THAT(error.what(), HasSubstr(file().string() + ": belongs to another pair"));
  }
}

TEST_F(KeptVerdictTest, ThatCannotBeWrittenIsAFault) {
  fs::create_directories(file());  // a folder in its place
  EXPECT_THROW(verdict_.keep({}), pusht::RuntimeFault);
  EXPECT_THROW(verdict_.find(), pusht::BadDependency);
  pusht::writeFile(folder_.path() / "file", "");
  EXPECT_THROW(KeptVerdict(folder_.path() / "file" / "audits", kPair).keep({}), pusht::RuntimeFault);
}

TEST(AuditText, NamesBothSimulatorsAsARunDoes) {
  const SimulatorRecord engine = {"two_mass", "two-mass engine", {{"block_damp", 20.0}}, {}, {"block_damp"}};
  const SimulatorRecord reference = {"mujoco", "MuJoCo"};
  const auto written = nlohmann::ordered_json::parse(auditText({{"seed", 3}}, reference, engine));
  EXPECT_EQ(written.at("format"), 1);
  EXPECT_EQ(written.at("seed"), 3);
  EXPECT_EQ(written.at("simulators").at("reference"), toJson(reference));
  EXPECT_EQ(written.at("simulators").at("engine"), toJson(engine));
  EXPECT_TRUE(nlohmann::json::parse(auditText(nlohmann::ordered_json::object(), std::nullopt, engine))
                  .at("simulators")
                  .at("reference")
                  .is_null());
}

}  // namespace
}  // namespace sim2sim
