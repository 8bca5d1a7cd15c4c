// SPDX-License-Identifier: BSD-3-Clause
/// Where the squares of a strip of episodes are. Without widgets.
#pragma once

#include <cstdint>
#include <optional>

namespace pusht_rviz {

/// Rows of squares of one size, in the order of the episodes. Where not all fit at the least size, those around the
/// episode that is shown do: whole rows of them.
struct StripLayout {
  int pitch = 0;            ///< [px] from one square to the next, the gap included
  int columns = 1;          ///< squares in a row
  std::uint64_t begin = 0;  ///< place of the first square, counted from the first episode
  std::uint64_t end = 0;    ///< place after the last one

  int rows() const;

  /// Left and upper edge of a square [px].
  int left(std::uint64_t place) const;
  int top(std::uint64_t place) const;

  /// Place of the square at a point [px]; none beside all of them.
  std::optional<std::uint64_t> placeAt(int x, int y) const;
};

/// For `count` episodes in `width` x `height` [px], with the one at `shown` among them; pitches between `least` and
/// `greatest` [px].
StripLayout layOut(std::uint64_t count, std::uint64_t shown, int width, int height, int least, int greatest);

}  // namespace pusht_rviz
