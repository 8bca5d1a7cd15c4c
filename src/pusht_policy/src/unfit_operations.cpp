// SPDX-License-Identifier: BSD-3-Clause
#include "unfit_operations.hpp"

#include <algorithm>

#include "pusht_task/joined.hpp"

namespace pusht {
namespace {

void addOnce(std::vector<std::string>& texts, const std::string& text) {
  if (std::find(texts.begin(), texts.end(), text) == texts.end()) {
    texts.push_back(text);
  }
}

}  // namespace

void UnfitOperations::addUnknown(const std::string& name) { addOnce(unknown_, name); }

void UnfitOperations::add(const std::string& name, const std::string& why) { addOnce(others_, name + ": " + why); }

std::string UnfitOperations::text() const {
  constexpr std::size_t kMost = 20;
  std::string text;
  if (!unknown_.empty()) {
    std::vector<std::string> names = unknown_;
    names.resize(std::min(names.size(), kMost));
    text = joined(names) + (unknown_.size() > kMost ? ", ..." : "") +
           (unknown_.size() == 1 ? ": is not known to the kernel" : ": are not known to the kernel");
  }
  for (std::size_t i = 0; i < std::min(others_.size(), kMost); ++i) {
    text += (text.empty() ? "" : "; ") + others_[i];
  }
  return text;
}

}  // namespace pusht
