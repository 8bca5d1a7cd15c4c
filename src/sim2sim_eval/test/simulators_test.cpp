// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/simulators.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/testing/refusal.hpp"
#include "pusht_task/testing/scenarios.hpp"

namespace sim2sim {
namespace {

using pusht::testing::refusalOf;
using ::testing::HasSubstr;

std::vector<std::string> namesOf(const pusht::SimulatorKind& kind) {
  std::vector<std::string> names;
  for (const pusht::ParameterDescriptor& parameter : kind.parameters) {
    names.push_back(parameter.name);
  }
  return names;
}

TEST(SimulatorKinds, AreFoundByTheirNames) {
  for (const pusht::SimulatorKind& kind : simulatorKinds()) {
    EXPECT_EQ(&simulatorKind(kind.name), &kind);
  }
  EXPECT_EQ(refusalOf([] { simulatorKind("bullet"); }),
            "simulator 'bullet': there is none of that name; there are: " + pusht::joined(kindNames()));
}

TEST(SimulatorKinds, AreDescribedInFull) {
  for (const pusht::SimulatorKind& kind : simulatorKinds()) {
    EXPECT_FALSE(kind.title.empty() || kind.version.empty() || kind.libraries.empty()) << kind.name;
    EXPECT_GT(kind.start_tolerance, 0.0) << kind.name;
    for (const pusht::ParameterDescriptor& parameter : kind.parameters) {
      EXPECT_FALSE(parameter.meaning.empty()) << kind.name << " " << parameter.name;
      EXPECT_EQ(parameter.read(pusht::textOf(parameter.default_value)), parameter.default_value) << parameter.name;
    }
  }
}

/// Another value of a parameter; none for a text that may be anything, as a file's name.
std::optional<std::string> otherValue(const pusht::ParameterDescriptor& parameter) {
  if (const auto* const real = std::get_if<double>(&parameter.default_value)) {
    const double other = *real == 0.0 ? 0.5 * parameter.greatest : 0.5 * *real;
    return pusht::shortestText(std::clamp(other, parameter.least, parameter.greatest));
  }
  if (const auto* const integer = std::get_if<std::int64_t>(&parameter.default_value)) {
    return std::to_string(*integer / 2 == *integer ? static_cast<std::int64_t>(parameter.greatest) : *integer / 2);
  }
  if (const auto* const flag = std::get_if<bool>(&parameter.default_value)) {
    return *flag ? "false" : "true";
  }
  for (const std::string& word : parameter.words) {
    if (parameter.default_value != pusht::ParameterValue(word)) {
      return word;
    }
  }
  return std::nullopt;
}

/// Where a chase from some starts leads.
std::vector<pusht::WorldState> endsOf(const pusht::SimulatorModel& model) {
  constexpr int kSteps = 60;
  std::vector<pusht::WorldState> ends;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto world = model.make_world();
    world->reset(pusht::spawn(seed));
    for (int step = 0; step < kSteps; ++step) {
      world->step(pusht::testing::chase(world->state()));
    }
    ends.push_back(world->state());
  }
  return ends;
}

/// Whoever adds a parameter is told here what it must do and where it must appear.
TEST(EveryParameter, ChangesATrajectoryAndIsInRecordHashAndReadme) {
  for (const pusht::SimulatorKind& kind : simulatorKinds()) {
    const auto library = std::find_if(kind.libraries.begin(), kind.libraries.end(),
                                      [](const std::string& name) { return name.rfind("libpusht_", 0) == 0; });
    ASSERT_NE(library, kind.libraries.end()) << kind.name << " must name its own library";
    const std::string package = library->substr(3, library->size() - 6);  // between lib and .so
    const std::string readme = pusht::readFile(std::filesystem::path(PUSHT_PACKAGES) / package / "README.md", "README");
    RunConfiguration configuration;
    configuration.engine = LoadedSimulator(chooseSimulator(kind.name, {})).record();
    const std::string default_hash = configurationHash(configuration);
    const auto default_ends = endsOf(kind.load(kind.defaults()));
    for (const pusht::ParameterDescriptor& parameter : kind.parameters) {
      SCOPED_TRACE(kind.name + " " + parameter.name);
      EXPECT_THAT(readme, HasSubstr("`" + parameter.name + "`"));
      const std::optional<std::string> value = otherValue(parameter);
      if (!value) {
        continue;
      }
      const LoadedSimulator other(chooseSimulator(kind.name, {parameter.name + "=" + *value}));
      EXPECT_NE(endsOf(other.model), default_ends);
      configuration.engine = other.record();
      if (parameter.presets.empty()) {
        EXPECT_EQ(configuration.engine.changed, std::vector<std::string>{parameter.name});
      } else {
        EXPECT_EQ(configuration.engine.changed.front(), parameter.name) << "and then what it sets";
      }
      EXPECT_EQ(configuration.engine.units.value(parameter.name, ""), parameter.unit);
      EXPECT_NE(configurationHash(configuration), default_hash);
      EXPECT_EQ(toJson(simulatorFrom(toJson(configuration.engine))), toJson(configuration.engine));
    }
  }
}

/// compare.launch has short forms of the course's parameters; it cannot read their descriptions by itself.
TEST(CompareLaunch, DescribesItsShortFormsAsTheKindsDo) {
  const std::string launch =
      pusht::readFile(std::filesystem::path(PUSHT_PACKAGES) / "sim2sim_eval/launch/compare.launch", "launch file");
  for (const char* name : {"pusher_mass", "block_damp", "baumgarte"}) {
    const pusht::ParameterSet knobs = simulatorKind("two_mass").defaults();
    const pusht::ParameterDescriptor& knob = knobs.at(name).descriptor;
    const std::string default_text = std::to_string(static_cast<int>(knobs.get<double>(name)));
    EXPECT_THAT(launch, HasSubstr(std::string("<arg name=\"") + name + "\" default=\"\" doc=\"engine: " + knob.meaning +
                                  " [" + knob.unit + "] (default: " + default_text + ")\""));
  }
}

TEST(ChooseSimulator, SetsWhatIsNamed) {
  const SimulatorChoice choice = chooseSimulator("two_mass", {"block_damp=20", "pusher_mass=1e-3"});
  EXPECT_EQ(choice.parameters.get<double>("block_damp"), 20.0);
  EXPECT_EQ(choice.parameters.get<double>("pusher_mass"), 1e-3);
  EXPECT_TRUE(choice.parameters.at("baumgarte").isDefault());
}

TEST(ChooseSimulator, SaysWhatCannotBeSet) {
  const auto refusal = [](const std::vector<std::string>& settings) {
    return refusalOf([&] { chooseSimulator("two_mass", settings); });
  };
  EXPECT_EQ(refusal({"block_damp"}), "setting 'block_damp': must be NAME=VALUE");
  EXPECT_EQ(refusal({"block_damp=1", "block_damp=2"}), "setting 'block_damp=2': block_damp must be set once");
  EXPECT_EQ(refusal({"scene=a"}), "parameter 'scene': there is none of that name; there are: " +
                                      pusht::joined(namesOf(simulatorKind("two_mass"))));
  EXPECT_EQ(refusal({"block_damp=much"}), "block_damp 'much': must be a decimal number");
}

}  // namespace
}  // namespace sim2sim
