// SPDX-License-Identifier: BSD-3-Clause
/// Names in a message.
#pragma once

#include <string>

namespace pusht {

/// "a, b, c"; "none" if there are none.
template <class Names>
std::string joined(const Names& names, const char* separator = ", ") {
  std::string text;
  for (const auto& name : names) {
    text.append(text.empty() ? "" : separator).append(name);
  }
  return text.empty() ? "none" : text;
}

}  // namespace pusht
