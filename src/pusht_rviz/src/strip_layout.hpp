// SPDX-License-Identifier: BSD-3-Clause
/// Layout of the squares of a strip. Without widgets.
#pragma once

#include <cstdint>
#include <optional>

namespace pusht_rviz {

/// Rows of squares of one size, one for each episode in their order. If not all fit at the least size, whole rows
/// around the episode that is shown are laid out.
struct StripLayout {
  int pitch = 0;            ///< [px] from one square to the next, the gap included
  int columns = 1;          ///< squares in a row
  std::uint64_t begin = 0;  ///< index of the first square, counted from the first episode
  std::uint64_t end = 0;    ///< index after that of the last square

  int rows() const;

  /// Left and upper edge of a square [px].
  int left(std::uint64_t index) const;
  int top(std::uint64_t index) const;

  /// Index of the square at a point [px]; none beside all of them.
  std::optional<std::uint64_t> indexAt(int x, int y) const;
};

/// Layout of `count` squares in `width` x `height` [px] that has the one with index `shown`. Its pitch is from `least`
/// to `greatest` [px].
StripLayout layOut(std::uint64_t count, std::uint64_t shown, int width, int height, int least, int greatest);

}  // namespace pusht_rviz
