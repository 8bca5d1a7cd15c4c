// SPDX-License-Identifier: BSD-3-Clause
/// The kinds of simulators that packages export, found by name.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/simulator_kind.hpp"

namespace pusht {

/// Kinds by name. Packages declare them as they declare classes for pluginlib: package.xml exports
/// `<pusht_task plugin="${prefix}/plugin_description.xml"/>`, and that file says which library has which kinds. A
/// library is loaded when one of its kinds is asked for by name. Not thread-safe.
class SimulatorKinds {
 public:
  /// Reads plugin descriptions. Libraries are in the first of the `folders` that has them; a kind whose library is in
  /// none is not built. An error in a description is reported by named(), for an unknown name.
  SimulatorKinds(const std::vector<std::filesystem::path>& descriptions,
                 const std::vector<std::filesystem::path>& folders);
  /// Kinds that need no library.
  explicit SimulatorKinds(const std::vector<SimulatorKind>& kinds);

  SimulatorKinds(const SimulatorKinds&) = delete;
  SimulatorKinds& operator=(const SimulatorKinds&) = delete;

  /// Kinds that packages on the ROS package path export, read at the first call. Libraries are in the workspaces of
  /// CMAKE_PREFIX_PATH.
  static const SimulatorKinds& installed();

  /// Names of the kinds that are built, in alphabetical order.
  std::vector<std::string> names() const;
  /// Whether a kind is built. It may still fail to load.
  bool has(const std::string& name) const;

  /// The kind of that name, whose `libraries` begin with its own. Throws InvalidInput with the names that there are for
  /// an unknown name. Throws BadDependency if the kind is not built, if two libraries have it, if its library cannot be
  /// loaded, has no such kind, or was built with other headers; and for an unknown name if a description has an error.
  const SimulatorKind& named(const std::string& name) const;
  /// Null where named() throws.
  const SimulatorKind* find(const std::string& name) const;

 private:
  /// A line of a description.
  struct Declaration {
    std::filesystem::path description;
    std::string library;         // "libpusht_engine.so"
    std::filesystem::path path;  // of the library; empty: not built
  };

  explicit SimulatorKinds(const BadDependency& error);

  void read(const std::filesystem::path& description, const std::vector<std::filesystem::path>& folders);
  const std::filesystem::path& libraryOf(const std::string& name) const;
  [[noreturn]] void refuseUnknown(const std::string& name) const;

  std::map<std::string, std::vector<Declaration>> declarations_;
  std::vector<std::string> errors_;  // where kinds may be missing
  mutable std::map<std::string, SimulatorKind> loaded_;
};

}  // namespace pusht
