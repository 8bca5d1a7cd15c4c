// SPDX-License-Identifier: BSD-3-Clause
#include "strip_layout.hpp"

#include <algorithm>

namespace pusht_rviz {

int StripLayout::rows() const {
  const auto squares = static_cast<int>(end - begin);
  return (squares + columns - 1) / columns;
}

int StripLayout::left(std::uint64_t index) const { return pitch * (static_cast<int>(index - begin) % columns); }

int StripLayout::top(std::uint64_t index) const { return pitch * (static_cast<int>(index - begin) / columns); }

std::optional<std::uint64_t> StripLayout::indexAt(int x, int y) const {
  if (pitch <= 0 || x < 0 || y < 0 || x >= pitch * columns) {
    return std::nullopt;
  }
  const std::uint64_t index = begin + static_cast<std::uint64_t>(y / pitch * columns + x / pitch);
  return index < end ? std::optional(index) : std::nullopt;
}

StripLayout layOut(std::uint64_t count, std::uint64_t shown, int width, int height, int least, int greatest) {
  StripLayout layout;
  layout.pitch = greatest;
  const auto room = [&] {
    layout.columns = std::max(1, width / layout.pitch);
    return static_cast<std::uint64_t>(layout.columns) * static_cast<std::uint64_t>(std::max(1, height / layout.pitch));
  };
  while (room() < count && layout.pitch > least) {
    --layout.pitch;
  }
  const std::uint64_t fit = room();
  const auto row = static_cast<std::uint64_t>(layout.columns);
  if (count > fit) {
    const std::uint64_t last_begin = (count - fit + row - 1) / row * row;
    const std::uint64_t wanted = shown < fit / 2 ? 0 : (shown - fit / 2) / row * row;
    layout.begin = std::min(wanted, last_begin);
  }
  layout.end = std::min(count, layout.begin + fit);
  return layout;
}

}  // namespace pusht_rviz
