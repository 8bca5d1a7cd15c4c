// SPDX-License-Identifier: BSD-3-Clause
/// Clipping of long texts in messages.
#pragma once

#include <cstddef>
#include <string>

namespace pusht {

/// Greatest length of an error's message [bytes].
constexpr std::size_t kLongestMessage = 2000;

/// `text` if it has at most `longest` bytes; else its begin and its end, and how many bytes are left out between them.
/// UTF-8 stays whole. Every message that leaves a program or a node is clipped: a value of 10 MB is named, not copied.
inline std::string clipped(const std::string& text, std::size_t longest = kLongestMessage) {
  if (text.size() <= longest) {
    return text;
  }
  const auto within_character = [&](std::size_t place) {
    return place < text.size() && (static_cast<unsigned char>(text[place]) & 0xC0U) == 0x80U;
  };
  std::size_t begin = longest / 2;
  std::size_t end = text.size() - longest / 2;
  while (begin > 0 && within_character(begin)) {
    --begin;
  }
  while (within_character(end)) {
    ++end;
  }
  return text.substr(0, begin) + " ... (" + std::to_string(end - begin) + " bytes left out) ... " + text.substr(end);
}

}  // namespace pusht
