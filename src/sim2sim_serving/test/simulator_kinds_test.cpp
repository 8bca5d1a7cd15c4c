// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/simulator_kinds.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "pusht_task/simulator_plugin.hpp"
#include "pusht_testing/refusal.hpp"
#include "pusht_testing/temporary_folder.hpp"
#include "pusht_testing/toy_world.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::refusalOf;
using ::testing::StartsWith;

/// The element of a plugin description that declares a kind.
std::string classOf(const std::string& name) {
  return "<class name=\"" + name + "\" base_class_type=\"pusht::SimulatorKind\"><description/></class>\n";
}

std::string libraryWith(const std::string& path, const std::string& classes) {
  return "<library path=\"" + path + "\">\n" + classes + "</library>\n";
}

/// Plugin descriptions in a folder, for the libraries that are built beside this test.
class PluginDescriptions : public ::testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& xml) const {
    fs::path path = folder_ / name;
    std::ofstream(path) << xml;
    return path;
  }

  /// The kinds that one description declares.
  SimulatorKinds kindsIn(const std::string& xml) const {
    return SimulatorKinds({write("plugin_description.xml", xml)}, {"/no/such/folder", PUSHT_PLUGINS});
  }

  std::string folder() const { return folder_.path().string(); }

 private:
  testing::TemporaryFolder folder_;
};

template <class Kind>
std::string refusalIn(const SimulatorKinds& kinds, const std::string& name) {
  EXPECT_EQ(kinds.find(name), nullptr);
  return refusalOf<Kind>([&] { kinds.named(name); });
}

const std::string kToyPlugin = std::string(PUSHT_PLUGINS) + "/libtoy_plugin.so";

TEST_F(PluginDescriptions, ListTheKindsByTheAlphabet) {
  const SimulatorKinds kinds = kindsIn(libraryWith("libtoy_plugin", classOf("toy") + classOf("stale")));
  EXPECT_THAT(kinds.names(), ElementsAre("stale", "toy")) << "whatever their library says once it is loaded";
  EXPECT_TRUE(kinds.has("toy"));
  EXPECT_FALSE(kinds.has("tow"));
  EXPECT_EQ(refusalIn<InvalidInput>(kinds, "tow"), "simulator 'tow': unknown; known: stale, toy");
}

TEST_F(PluginDescriptions, GiveTheKindsOfLibraries) {
  const SimulatorKinds kinds = kindsIn(libraryWith("libtoy_plugin", classOf("toy")));
  const SimulatorKind& kind = kinds.named("toy");
  EXPECT_EQ(kind.title, "toy");
  EXPECT_THAT(kind.libraries, ElementsAre("libtoy_plugin.so"));
  EXPECT_EQ(&kinds.named("toy"), &kind);
  EXPECT_EQ(kinds.find("toy"), &kind);
  const auto world = kind.load(kind.defaults()).make_world();
  world->reset({});
  world->step({1.0, 0.0});
  EXPECT_GT(world->state().pusher_position.x(), 0.0);
}

TEST_F(PluginDescriptions, MayHaveSeveralLibrariesAndPluginsOfOtherKinds) {
  const SimulatorKinds kinds = kindsIn("<class_libraries>" + libraryWith("libtoy_plugin", classOf("toy")) +
                                       libraryWith("libpanel", "<class base_class_type=\"rviz::Panel\"/>") +
                                       libraryWith("libunresolved_plugin", classOf("lost")) + "</class_libraries>");
  EXPECT_THAT(kinds.names(), ElementsAre("lost", "toy"));
}

TEST_F(PluginDescriptions, DoNotListWhatIsNotBuilt) {
  const SimulatorKinds kinds = kindsIn(libraryWith("libno_such_plugin", classOf("planned")));
  EXPECT_THAT(kinds.names(), IsEmpty());
  EXPECT_EQ(refusalIn<BadDependency>(kinds, "planned"),
            "simulator 'planned': libno_such_plugin.so of " + folder() +
                "/plugin_description.xml is in no workspace of CMAKE_PREFIX_PATH: build it, and source its setup.bash");
}

TEST_F(PluginDescriptions, TwoOfThemMustNotHaveOneName) {
  const fs::path a = write("a.xml", libraryWith("libtoy_plugin", classOf("toy")));
  const fs::path b = write("b.xml", libraryWith("libunresolved_plugin", classOf("toy") + classOf("lost")));
  const fs::path c = write("c.xml", libraryWith("libno_such_plugin", classOf("lost")));
  const SimulatorKinds kinds({a, b, c}, {PUSHT_PLUGINS});
  EXPECT_THAT(kinds.names(), ElementsAre("lost", "toy"));
  EXPECT_EQ(refusalIn<BadDependency>(kinds, "toy"),
            "simulator 'toy': is in " + a.string() + " and in " + b.string() + "; a name must be that of one kind");
  EXPECT_THAT(refusalIn<BadDependency>(kinds, "lost"), HasSubstr("libunresolved_plugin.so"))
      << "that of a library which is not built does not count";
}

TEST_F(PluginDescriptions, SayWhatIsWrongWithThemWhenAKindIsNotFound) {
  const fs::path right = write("right.xml", libraryWith("libtoy_plugin", classOf("toy")));
  const auto refusal = [&](const std::string& xml) {
    const SimulatorKinds kinds({write("wrong.xml", xml), right}, {PUSHT_PLUGINS});
    EXPECT_EQ(kinds.named("toy").name, "toy") << "the others work";
    const std::string message = refusalIn<BadDependency>(kinds, "lost");
    const std::string start = "simulator 'lost': unknown; known: toy; " + folder() + "/wrong.xml: ";
    EXPECT_THAT(message, StartsWith(start));
    return message.substr(std::min(start.size(), message.size()));
  };
  EXPECT_EQ(refusal("<library path=\"lib\">\n<class>\n</library>"),
            "line 2: XML_ERROR_MISMATCHED_ELEMENT; must be a plugin description in XML");
  EXPECT_EQ(refusal(""), "line 0: XML_ERROR_EMPTY_DOCUMENT; must be a plugin description in XML");
  EXPECT_EQ(refusal("<library>" + classOf("lost") + "</library>"), "line 1: <library>: must have a path");
  EXPECT_EQ(refusal("<library path=\"lib\">\n<class base_class_type=\"pusht::SimulatorKind\"/></library>"),
            "line 2: <class>: must have a name");
  EXPECT_EQ(refusal("<plugins/>"), "line 1: <plugins>: must be <library> or <class_libraries>");
}

TEST_F(PluginDescriptions, OfAFileThatIsNotThere) {
  const SimulatorKinds kinds({"/no/such/file.xml"}, {PUSHT_PLUGINS});
  EXPECT_EQ(refusalIn<BadDependency>(kinds, "toy"),
            "simulator 'toy': unknown; known: none; /no/such/file.xml: line 0: XML_ERROR_FILE_NOT_FOUND; must be a "
            "plugin description in XML");
}

TEST_F(PluginDescriptions, RefuseALibraryThatWasBuiltWithOtherHeaders) {
  const SimulatorKinds kinds = kindsIn(libraryWith("libtoy_plugin", classOf("stale")));
  EXPECT_EQ(refusalIn<BadDependency>(kinds, "stale"), "library " + kToyPlugin +
                                                          ": was built with pusht_task 0.0.1 0123456789ab; must be " +
                                                          kSimulatorInterface + ": build its workspace again");
}

TEST_F(PluginDescriptions, RefuseALibraryWithoutTheKind) {
  const SimulatorKinds kinds = kindsIn(libraryWith("libtoy_plugin", classOf("absent") + classOf("other_name")));
  EXPECT_EQ(refusalIn<BadDependency>(kinds, "absent"),
            "library " + kToyPlugin +
                ": has no symbol pusht_simulator_absent; must export the kind (PUSHT_EXPORT_SIMULATOR_KIND), as "
                "plugin_description.xml says");
  EXPECT_EQ(refusalIn<BadDependency>(kinds, "other_name"),
            "library " + kToyPlugin + ": its kind 'toy' must be named 'other_name', as plugin_description.xml says");
}

TEST_F(PluginDescriptions, RefuseALibraryThatMissesASymbol) {
  const SimulatorKinds kinds = kindsIn(libraryWith("libunresolved_plugin", classOf("lost")));
  const std::string message = refusalIn<BadDependency>(kinds, "lost");
  EXPECT_THAT(message,
              StartsWith("library " + std::string(PUSHT_PLUGINS) + "/libunresolved_plugin.so: cannot be loaded: "));
  EXPECT_THAT(message, HasSubstr("undefined symbol: pusht_nowhere"));
}

TEST(SimulatorKinds, CanBeThoseAtHand) {
  const SimulatorKinds kinds(std::vector{toyKind()});
  EXPECT_THAT(kinds.names(), ElementsAre("toy"));
  EXPECT_EQ(kinds.named("toy").name, "toy");
}

TEST(SimulatorInterface, IsAVersionAndAHash) {
  EXPECT_THAT(kSimulatorInterface, ::testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+ [0-9a-f]{12}"));
}

}  // namespace
}  // namespace pusht
