// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/simulator_kinds.hpp"

#include <rospack/rospack.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/library.hpp"
#include "pusht_task/simulator_plugin.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;
using tinyxml2::XMLElement;

constexpr const char* kBaseClass = "pusht::SimulatorKind";

/// Throws InvalidInput if there is none.
std::string attribute(const XMLElement& element, const char* name) {
  const char* const value = element.Attribute(name);
  if (value == nullptr || *value == '\0') {
    throw InvalidInput("line " + std::to_string(element.GetLineNum()) + ": <" + element.Name() + ">: must have a " +
                       name);
  }
  return value;
}

/// The first of the folders' files of that name; empty if there is none.
fs::path fileIn(const std::vector<fs::path>& folders, const std::string& name) {
  for (const fs::path& folder : folders) {
    std::error_code ignored;
    if (fs::path path = folder / name; fs::exists(path, ignored)) {
      return path;
    }
  }
  return {};
}

/// Throws BadDependency as SimulatorKinds::named.
SimulatorKind load(const std::string& name, const fs::path& path) {
  const std::string symbol = kSimulatorPluginSymbol + name;
  const auto* const plugin = Library(path).find<SimulatorPlugin>(symbol);
  if (plugin == nullptr) {
    throw BadDependency("library " + path.string() + ": has no symbol " + symbol +
                        "; must export the kind (PUSHT_EXPORT_SIMULATOR_KIND), as plugin_description.xml says");
  }
  if (plugin->interface != std::string(kSimulatorInterface)) {
    throw BadDependency("library " + path.string() + ": was built with pusht_task " + plugin->interface + "; must be " +
                        kSimulatorInterface + ": build its workspace again");
  }
  SimulatorKind kind = plugin->kind();
  if (kind.name != name) {
    throw BadDependency("library " + path.string() + ": its kind '" + kind.name + "' must be named '" + name +
                        "', as plugin_description.xml says");
  }
  kind.libraries.insert(kind.libraries.begin(), path.filename());
  return kind;
}

/// The descriptions that packages on the ROS package path export. Throws BadDependency if there is none, or a
/// package.xml that is not right.
std::vector<fs::path> exportedDescriptions() {
  rospack::Rospack packages;
  packages.setQuiet(true);
  std::vector<std::string> path;
  std::vector<fs::path> descriptions;
  try {
    std::vector<std::string> exports;  // "PACKAGE DESCRIPTION"
    if (packages.getSearchPathFromEnv(path)) {
      packages.crawl(path, false);
      packages.plugins("pusht_task", "plugin", "", exports);
    }
    for (const std::string& line : exports) {
      descriptions.emplace_back(line.substr(line.find(' ') + 1));
    }
  } catch (const std::runtime_error& error) {
    throw BadDependency(std::string("ROS_PACKAGE_PATH: ") + error.what());
  }
  if (descriptions.empty()) {
    throw BadDependency("no package on ROS_PACKAGE_PATH has any: source the workspace's setup.bash");
  }
  return descriptions;
}

/// Where the workspaces in use have their libraries, the overlay's first.
std::vector<fs::path> libraryFolders() {
  const char* const prefixes = std::getenv("CMAKE_PREFIX_PATH");
  std::istringstream list(prefixes == nullptr ? "" : prefixes);
  std::vector<fs::path> folders;
  for (std::string prefix; std::getline(list, prefix, ':');) {
    folders.push_back(fs::path(prefix) / "lib");
  }
  return folders;
}

}  // namespace

SimulatorKinds::SimulatorKinds(const std::vector<fs::path>& descriptions, const std::vector<fs::path>& folders) {
  for (const fs::path& description : descriptions) {
    try {
      read(description, folders);
    } catch (const InvalidInput& error) {
      errors_.push_back(description.string() + ": " + error.what());
    }
  }
}

SimulatorKinds::SimulatorKinds(const std::vector<SimulatorKind>& kinds) {
  for (const SimulatorKind& kind : kinds) {
    loaded_.emplace(kind.name, kind);
  }
}

SimulatorKinds::SimulatorKinds(const BadDependency& error) : errors_{error.what()} {}

const SimulatorKinds& SimulatorKinds::installed() {
  static const SimulatorKinds kinds = [] {
    try {
      return SimulatorKinds(exportedDescriptions(), libraryFolders());
    } catch (const BadDependency& error) {
      return SimulatorKinds(error);
    }
  }();
  return kinds;
}

void SimulatorKinds::read(const fs::path& description, const std::vector<fs::path>& folders) {
  tinyxml2::XMLDocument document;
  if (document.LoadFile(description.c_str()) != tinyxml2::XML_SUCCESS) {
    throw InvalidInput("line " + std::to_string(document.ErrorLineNum()) + ": " + document.ErrorName() +
                       "; must be a plugin description in XML");
  }
  const XMLElement* library = document.RootElement();
  const std::string root = library->Name();
  if (root == "class_libraries") {
    library = library->FirstChildElement("library");
  } else if (root != "library") {
    throw InvalidInput("line " + std::to_string(library->GetLineNum()) + ": <" + root +
                       ">: must be <library> or <class_libraries>");
  }
  for (; library != nullptr; library = library->NextSiblingElement("library")) {
    const std::string file = attribute(*library, "path") + ".so";
    for (const XMLElement* kind = library->FirstChildElement("class"); kind != nullptr;
         kind = kind->NextSiblingElement("class")) {
      if (attribute(*kind, "base_class_type") == kBaseClass) {
        declarations_[attribute(*kind, "name")].push_back({description, file, fileIn(folders, file)});
      }
    }
  }
}

std::vector<std::string> SimulatorKinds::names() const {
  std::vector<std::string> names;
  for (const auto& [name, kind] : loaded_) {
    names.push_back(name);
  }
  for (const auto& [name, declarations] : declarations_) {
    if (loaded_.count(name) == 0 && has(name)) {
      names.push_back(name);
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool SimulatorKinds::has(const std::string& name) const {
  const auto declared = declarations_.find(name);
  return loaded_.count(name) > 0 ||
         (declared != declarations_.end() &&
          std::any_of(declared->second.begin(), declared->second.end(),
                      [](const Declaration& declaration) { return !declaration.path.empty(); }));
}

const SimulatorKind& SimulatorKinds::named(const std::string& name) const {
  const auto place = loaded_.find(name);
  return place != loaded_.end() ? place->second : loaded_.emplace(name, load(name, libraryOf(name))).first->second;
}

const fs::path& SimulatorKinds::libraryOf(const std::string& name) const {
  const auto declared = declarations_.find(name);
  if (declared == declarations_.end()) {
    refuseUnknown(name);
  }
  const Declaration* chosen = nullptr;
  for (const Declaration& declaration : declared->second) {
    if (chosen != nullptr && !declaration.path.empty()) {
      throw BadDependency("simulator '" + name + "': is in " + chosen->description.string() + " and in " +
                          declaration.description.string() + "; a name must be that of one kind");
    }
    chosen = declaration.path.empty() ? chosen : &declaration;
  }
  if (chosen == nullptr) {
    const Declaration& missing = declared->second.front();
    throw BadDependency("simulator '" + name + "': " + missing.library + " of " + missing.description.string() +
                        " is in no workspace of CMAKE_PREFIX_PATH: build it, and source its setup.bash");
  }
  return chosen->path;
}

void SimulatorKinds::refuseUnknown(const std::string& name) const {
  const std::string message = "simulator '" + name + "': unknown; known: " + joined(names());
  if (errors_.empty()) {
    throw InvalidInput(message);
  }
  throw BadDependency(message + "; " + joined(errors_, "; "));
}

const SimulatorKind* SimulatorKinds::find(const std::string& name) const {
  try {
    return &named(name);
  } catch (const Error&) {
    return nullptr;
  }
}

}  // namespace pusht
