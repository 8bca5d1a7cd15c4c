// SPDX-License-Identifier: BSD-3-Clause
/// Cells of a line, lines of a text.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace pusht {

/// Parts of a text between separators: one more than there are separators, so an empty text has one empty part.
inline std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

/// Cells of a line of CSV, blanks around them left out.
inline std::vector<std::string> cellsOf(const std::string& line) {
  constexpr const char* kBlank = " \t\r";
  std::vector<std::string> cells = split(line, ',');
  for (std::string& cell : cells) {
    const std::size_t begin = std::min(cell.find_first_not_of(kBlank), cell.size());
    cell = cell.substr(begin, cell.find_last_not_of(kBlank) + 1 - begin);
  }
  return cells;
}

}  // namespace pusht
