// SPDX-License-Identifier: BSD-3-Clause
/// Operations of a network that the kernel cannot run, all of them, for one message.
#pragma once

#include <string>
#include <vector>

#include "network_builder.hpp"

namespace pusht {

/// Collects operations, each once.
class UnfitOperations {
 public:
  void addUnknown(const std::string& name);
  void add(const std::string& name, const std::string& why);

  bool empty() const { return unknown_.empty() && others_.empty(); }

  /// "aten::sin, aten::sort: are not known to the kernel; aten::add: its alpha must be 1"
  std::string text() const;

 private:
  std::vector<std::string> unknown_;
  std::vector<std::string> others_;
};

}  // namespace pusht
