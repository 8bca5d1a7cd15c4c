// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/simulators.hpp"

#include <gmock/gmock.h>
#include <link.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/refusal.hpp"
#include "pusht_testing/scenarios.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

namespace sim2sim {
namespace {

using pusht::testing::refusalOf;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::UnorderedElementsAreArray;

std::vector<std::string> namesOf(const pusht::SimulatorKind& kind) {
  std::vector<std::string> names;
  for (const pusht::ParameterDescriptor& parameter : kind.parameters) {
    names.push_back(parameter.name);
  }
  return names;
}

const pusht::SimulatorKind& simulatorKind(const std::string& name) {
  return pusht::SimulatorKinds::installed().named(name);
}

/// Every kind that is built.
std::vector<pusht::SimulatorKind> simulatorKinds() {
  std::vector<pusht::SimulatorKind> kinds;
  for (const std::string& name : pusht::SimulatorKinds::installed().names()) {
    kinds.push_back(simulatorKind(name));
  }
  return kinds;
}

TEST(SimulatorKinds, OfTheSuiteAreFoundByTheirNames) {
  EXPECT_THAT(pusht::SimulatorKinds::installed().names(),
              IsSupersetOf({"box2d", "bullet", "chipmunk", kCourseReference, "rigid_body", kCourseEngine}));
  EXPECT_EQ(refusalOf([] { simulatorKind("bulet"); }),
            "simulator 'bulet': unknown; known: " + pusht::joined(pusht::SimulatorKinds::installed().names()));
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

/// A shared library that is loaded.
struct Loaded {
  std::string file;                 ///< name of its file: "libchipmunk.so.7.0.3"
  std::vector<std::string> needed;  ///< "libchipmunk.so.7": those that it is linked to
};

// NOLINTBEGIN(performance-no-int-to-ptr): the loader tells addresses as numbers
std::vector<std::string> neededBy(const dl_phdr_info& info) {
  std::vector<std::string> needed;
  for (ElfW(Half) i = 0; i < info.dlpi_phnum; ++i) {
    if (info.dlpi_phdr[i].p_type != PT_DYNAMIC) {
      continue;
    }
    const auto* const first = reinterpret_cast<const ElfW(Dyn)*>(info.dlpi_addr + info.dlpi_phdr[i].p_vaddr);
    const char* names = nullptr;
    for (const auto* entry = first; entry->d_tag != DT_NULL; ++entry) {
      names = entry->d_tag == DT_STRTAB ? reinterpret_cast<const char*>(entry->d_un.d_ptr) : names;
    }
    for (const auto* entry = first; entry->d_tag != DT_NULL; ++entry) {
      if (entry->d_tag == DT_NEEDED) {
        needed.emplace_back(names + entry->d_un.d_val);
      }
    }
  }
  return needed;
}
// NOLINTEND(performance-no-int-to-ptr)

std::vector<Loaded> loadedLibraries() {
  std::vector<Loaded> libraries;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t /*size*/, void* list) {
        if (std::filesystem::exists(info->dlpi_name)) {  // not the program, not the kernel's
          static_cast<std::vector<Loaded>*>(list)->push_back(
              {std::filesystem::canonical(info->dlpi_name).filename(), neededBy(*info)});
        }
        return 0;
      },
      &libraries);
  return libraries;
}

/// The first that is loaded whose file's name begins with that `name`.
Loaded loadedLibrary(const std::string& name) {
  for (const Loaded& library : loadedLibraries()) {
    if (library.file.rfind(name, 0) == 0) {
      return library;
    }
  }
  throw pusht::InternalError("library " + name + ": is not loaded");
}

bool isNamed(const std::string& file, const std::vector<std::string>& libraries) {
  return std::any_of(libraries.begin(), libraries.end(),
                     [&](const std::string& library) { return file.rfind(library, 0) == 0; });
}

/// What the kinds' own libraries are linked to, besides what is every kind's, and no kind names.
std::vector<std::string> forgottenLibraries(const std::vector<pusht::SimulatorKind>& kinds) {
  std::vector<std::string> named = loadedLibrary("libpusht_task.so").needed;
  named.insert(named.end(), {"libpusht_task.so", "libm.so", "ld-linux"});
  for (const pusht::SimulatorKind& kind : kinds) {
    named.insert(named.end(), kind.libraries.begin(), kind.libraries.end());
  }
  std::vector<std::string> forgotten;
  for (const pusht::SimulatorKind& kind : kinds) {
    for (const std::string& library : kind.libraries) {
      if (library.rfind("libpusht_", 0) != 0) {
        continue;
      }
      for (const std::string& needed : loadedLibrary(library).needed) {
        if (!isNamed(needed, named)) {
          forgotten.push_back(needed);
        }
      }
    }
  }
  return forgotten;
}

/// A kept reference is used again as long as these libraries have the same bytes.
TEST(SimulatorKinds, NameEveryLibraryThatTheirOwnIsLinkedTo) {
  EXPECT_EQ(forgottenLibraries(simulatorKinds()), std::vector<std::string>());
  pusht::SimulatorKind forgetful = simulatorKind("chipmunk");
  forgetful.libraries = {"libpusht_chipmunk.so"};
  EXPECT_EQ(forgottenLibraries({forgetful}), std::vector<std::string>{"libchipmunk.so.7"});
}

/// A version as "7.0.3" in the file's name of the engine's library is the kind's version. (libccd has no third number.)
TEST(SimulatorKinds, TellTheVersionOfTheLibraryThatIsLoaded) {
  const std::regex versioned("lib.*\\.so\\.(\\d+\\.\\d+\\.\\d+)");
  int found = 0;
  for (const pusht::SimulatorKind& kind : simulatorKinds()) {
    for (const std::string& library : kind.libraries) {
      const std::string file = loadedLibrary(library).file;
      if (std::smatch match; std::regex_match(file, match, versioned)) {
        EXPECT_EQ(kind.version, match[1]) << kind.name;
        ++found;
      }
    }
  }
  EXPECT_GT(found, 0);
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
std::vector<pusht::WorldState> endsOf(const LoadedSimulator& simulator) {
  constexpr int kSteps = 60;
  std::vector<pusht::WorldState> ends;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto world = simulator.model.make_world();
    world->reset(pusht::spawn(seed, simulator.task));
    for (int step = 0; step < kSteps; ++step) {
      world->step(pusht::testing::chase(world->state(), simulator.task));
    }
    ends.push_back(world->state());
  }
  return ends;
}

/// A file of the workspace.
std::string textOfFile(const std::string& path) {
  return pusht::readFile(std::filesystem::path(PUSHT_PACKAGES) / path, "file");
}

/// The tables' rows that begin with a name in code, cell by cell.
std::vector<std::vector<std::string>> rowsIn(const std::string& markdown) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(markdown);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("| `", 0) != 0) {
      continue;
    }
    rows.emplace_back();
    for (std::size_t begin = 2, end = 0; (end = line.find(" |", begin)) != std::string::npos; begin = end + 3) {
      rows.back().push_back(line.substr(begin, end - begin));
    }
  }
  return rows;
}

/// A README has a row for each number, with default and unit, range, and meaning; a row for each switch; and each word.
void expectDescribed(const pusht::ParameterDescriptor& parameter, const std::string& readme) {
  EXPECT_THAT(readme, HasSubstr("`" + parameter.name + "`"));
  for (const std::string& word : parameter.words) {
    EXPECT_THAT(readme, HasSubstr("`" + word + "`"));
  }
  if (std::holds_alternative<std::string>(parameter.default_value)) {
    return;
  }
  const auto rows = rowsIn(readme);
  const auto row = std::find_if(rows.begin(), rows.end(),
                                [&](const auto& cells) { return cells.front() == "`" + parameter.name + "`"; });
  ASSERT_NE(row, rows.end()) << "has no row";
  if (std::holds_alternative<bool>(parameter.default_value)) {
    return;
  }
  ASSERT_EQ(row->size(), 4U) << "name, default, range, meaning";
  const std::string& default_text = row->at(1);
  const std::size_t space = default_text.find(' ');
  EXPECT_EQ(parameter.read(default_text.substr(0, space)), parameter.default_value);
  EXPECT_EQ(space == std::string::npos ? "" : default_text.substr(space + 1), parameter.unit);
  const std::string& range = row->at(2);
  const std::size_t to = range.find(" to ");
  ASSERT_NE(to, std::string::npos) << range;
  EXPECT_EQ(std::stod(range), parameter.least);
  EXPECT_EQ(std::stod(range.substr(to + 4)), parameter.greatest);
  EXPECT_EQ(row->at(3), parameter.meaning);
}

/// Settings of other parameters without which one changes nothing.
std::vector<std::string> conditionOf(const std::string& kind, const std::string& parameter) {
  static const std::map<std::pair<std::string, std::string>, std::vector<std::string>> conditions = {
      {{"mujoco", "contact_time"}, {"timestep=0.005"}},  // it counts from two time steps on
      {{"mujoco", "impratio"}, {"cone=elliptic"}},
      {{"mujoco", "iterations"}, {"solver=PGS"}},  // Newton's method needs few
  };
  const auto found = conditions.find({kind, parameter});
  return found == conditions.end() ? std::vector<std::string>() : found->second;
}

/// A kind with settings, in the first of its tasks.
LoadedSimulator loaded(const pusht::SimulatorKind& kind, const std::vector<std::string>& settings) {
  SimulatorChoice choice = chooseSimulator(kind.name, settings);
  setTask(kind.ownTask(), {choice});
  return LoadedSimulator(choice);
}

/// Rules for a new parameter: what it must do and where it must appear.
TEST(EveryParameter, ChangesATrajectoryAndIsInRecordHashAndReadme) {
  for (const pusht::SimulatorKind& kind : simulatorKinds()) {
    const std::string& library = kind.libraries.front();
    const std::string package = library.substr(3, library.size() - 6);  // between lib and .so
    const std::string readme = textOfFile(package + "/README.md");
    for (const pusht::ParameterDescriptor& parameter : kind.parameters) {
      SCOPED_TRACE(kind.name + " " + parameter.name);
      expectDescribed(parameter, readme);
      const std::optional<std::string> value = otherValue(parameter);
      if (!value) {
        continue;
      }
      std::vector<std::string> settings = conditionOf(kind.name, parameter.name);
      const LoadedSimulator usual = loaded(kind, settings);
      RunConfiguration configuration;
      configuration.engine = usual.record();
      const std::string usual_hash = configurationHash(configuration);
      const std::size_t changed_before = configuration.engine.changed.size();
      settings.push_back(parameter.name + "=" + *value);
      const LoadedSimulator other = loaded(kind, settings);
      EXPECT_NE(endsOf(other), endsOf(usual));
      configuration.engine = other.record();
      if (parameter.presets.empty()) {
        EXPECT_EQ(configuration.engine.changed.size(), changed_before + 1);
        EXPECT_THAT(configuration.engine.changed, Contains(parameter.name));
      } else {
        EXPECT_EQ(configuration.engine.changed.front(), parameter.name) << "and then what it sets";
      }
      EXPECT_EQ(configuration.engine.units.value(parameter.name, ""), parameter.unit);
      EXPECT_NE(configurationHash(configuration), usual_hash);
      EXPECT_EQ(toJson(simulatorFrom(toJson(configuration.engine))), toJson(configuration.engine));
    }
  }
}

/// The switches of the rigid-body engine, in its order: what its presets set.
std::vector<std::string> switches() {
  std::vector<std::string> names;
  for (const pusht::ParameterDescriptor& parameter : simulatorKind("rigid_body").parameters) {
    if (!parameter.presets.empty()) {
      for (const auto& setting : parameter.presets.front().settings) {
        names.push_back(setting.first);
      }
    }
  }
  return names;
}

TEST(Ladder, TurnsEverySwitchOnAndOff) {
  std::string grid = "grid:\n";
  for (const std::string& name : switches()) {
    grid += "  " + name + ": [false, true]\n";
  }
  EXPECT_THAT(textOfFile("sim2sim_eval/config/ladder.yaml"), EndsWith(grid));
}

TEST(Ladder, ItsStoryHasEverySwitchInEachTable) {
  std::vector<std::string> named;
  for (const std::vector<std::string>& row : rowsIn(textOfFile("../docs/ladder.md"))) {
    named.push_back(row.front().substr(1, row.front().size() - 2));
  }
  const std::vector<std::string> names = switches();
  constexpr std::size_t kTables = 3;  // what they are, their shares, alone and left out
  ASSERT_EQ(named.size(), kTables * names.size());
  const auto size = static_cast<std::ptrdiff_t>(names.size());
  EXPECT_EQ(std::vector<std::string>(named.begin(), named.begin() + size), names);
  for (auto table = named.begin() + size; table != named.end(); table += size) {
    EXPECT_THAT(std::vector<std::string>(table, table + size), UnorderedElementsAreArray(names))
        << "in the order of its figures";
  }
}

/// compare.launch has short forms of the course's parameters; it cannot read their descriptions by itself.
TEST(CompareLaunch, DescribesItsShortFormsAsTheKindsDo) {
  const std::string launch = textOfFile("sim2sim_eval/launch/compare.launch");
  for (const auto& [role, kind] : {std::pair{"engine", kCourseEngine}, std::pair{"reference", kCourseReference}}) {
    int short_forms = 0;
    for (const pusht::ParameterDescriptor& parameter : simulatorKind(kind).parameters) {
      const std::string argument = "<arg name=\"" + parameter.name + "\"";
      if (launch.find(argument) == std::string::npos) {
        continue;  // engine_parameters:="NAME=VALUE" sets it
      }
      ++short_forms;
      const auto* const real = std::get_if<double>(&parameter.default_value);
      const std::string unit = parameter.unit.empty() ? "" : " [" + parameter.unit + "]";
      const std::string usual =
          real != nullptr ? pusht::significantText(*real, 6) : pusht::textOf(parameter.default_value);
      std::ostringstream wanted;
      wanted << argument << " default=\"auto\" doc=\"" << role << ": " << parameter.meaning << unit
             << " (default: " << usual << ")\"";
      EXPECT_THAT(launch, HasSubstr(wanted.str()));
    }
    EXPECT_GT(short_forms, 0) << role;
  }
}

TEST(CompareLaunch, ComparesTheKindsOfTheCourseUnlessItIsToldOthers) {
  const std::string launch = textOfFile("sim2sim_eval/launch/compare.launch");
  for (const std::string kind : {kCourseReference, kCourseEngine}) {
    EXPECT_THAT(launch, AnyOf(HasSubstr("\"" + kind + "\""), HasSubstr("'" + kind + "'")));
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
  EXPECT_EQ(refusal({"scene=a"}),
            "parameter 'scene': unknown; known: " + pusht::joined(namesOf(simulatorKind("two_mass"))));
  EXPECT_EQ(refusal({"block_damp=much"}), "block_damp 'much': must be a decimal number");
}

}  // namespace
}  // namespace sim2sim
