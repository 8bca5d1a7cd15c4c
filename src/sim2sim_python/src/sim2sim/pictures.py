# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of gym-pusht's world, by the calls of pygame and OpenCV that gym-pusht makes.

Source: gym-pusht 0.1.5, pymunk 6.6's drawing for debugging. The same bytes as there with pygame 2.1
and OpenCV 4.6.
"""

import os
from typing import Any, List, Tuple

import numpy as np
from numpy.typing import NDArray

from sim2sim._sim2sim import gym_pusht_keypoints
from sim2sim.errors import BadDependency
from sim2sim.sight import GOAL

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
try:
    import cv2  # type: ignore[import]
    import pygame
except ImportError as error:
    raise BadDependency(
        "pictures: need pygame and OpenCV (Debian's python3-pygame and python3-opencv), "
        f"but {error}"
    ) from None

VERSIONS = f"pygame {pygame.version.ver}, OpenCV {cv2.__version__}"

Point = Tuple[int, int]  # [px]
Color = Tuple[int, int, int]  # red, green, blue

SIDE = 512  # [px]
PUSHER_RADIUS = 15  # [px]
PUSHER_RIM = 4  # [px]
LINE_RADIUS = 2  # [px] of walls, and of the tee's outline
WALLS = (
    ((5, 506), (5, 5)),
    ((5, 5), (506, 5)),
    ((506, 5), (506, 506)),
    ((5, 506), (506, 506)),
)

WHITE = (255, 255, 255)
ROYAL_BLUE = (65, 105, 225)
LIGHT_SLATE_GRAY = (119, 136, 153)
LIGHT_GRAY = (211, 211, 211)
LIGHT_GREEN = (144, 238, 144)
CLEAR = (0, 0, 0)  # where the picture of the walls shows what is below
RED = (255, 0, 0)


def draw(pusher: NDArray[np.float64], keypoints: NDArray[np.float64]) -> Any:
    """A surface [512 x 512] of the pusher's position [2] and the tee's corners [16], in px. It is
    the module's own, until the next one is drawn."""
    surface = _SURFACE
    surface.blit(_BELOW, (0, 0))
    for part in keypoints.reshape(2, 4, 2):
        _draw_polygon(surface, [_pixel(corner) for corner in part], LIGHT_SLATE_GRAY)
    center = _pixel(pusher)
    pygame.draw.circle(surface, ROYAL_BLUE, center, PUSHER_RADIUS)
    pygame.draw.circle(surface, _lighter(ROYAL_BLUE), center, PUSHER_RADIUS - PUSHER_RIM)
    for strip in _STRIPS:
        surface.blit(_WALLS, strip, strip)
    return surface


def scaled(surface: Any, width: int, height: int) -> NDArray[np.uint8]:
    """The surface as an image [height, width, 3] of red, green, blue."""
    rows = pygame.surfarray.pixels2d(surface).T  # one number for each pixel
    channels = rows.view(np.uint8).reshape(SIDE, SIDE, 4)  # blue, green, red, and nothing
    return np.asarray(cv2.cvtColor(cv2.resize(channels, (width, height)), cv2.COLOR_BGRA2RGB))


def images(states: NDArray[np.float64], width: int, height: int) -> NDArray[np.uint8]:
    """Images [n, height, width, 3] of worlds in these states [n, 7], as PixelWorlds.states."""
    drawn = np.empty((len(states), height, width, 3), np.uint8)
    for image, state, keypoints in zip(drawn, states, gym_pusht_keypoints(states)):
        image[:] = scaled(draw(state[:2], keypoints), width, height)
    return drawn


def mark(image: NDArray[np.uint8], action: NDArray[np.float64]) -> None:
    """Draws a cross where an action [px] draws the pusher to."""
    height, width, _ = image.shape
    share = action / SIDE
    x, y = (int(number) for number in share * [height, width])
    size = min(width, height)
    cv2.drawMarker(
        image,
        (x, y),
        color=RED,
        markerType=cv2.MARKER_CROSS,
        markerSize=max(1, int(8 / 96 * size)),
        thickness=max(1, int(1 / 96 * size)),
    )


def _pixel(point: Any) -> Point:
    return round(point[0]), round(point[1])


def _lighter(color: Color) -> Color:
    red, green, blue = (min(255, round(1.2 * part)) for part in color)
    return red, green, blue


def _draw_polygon(surface: Any, corners: List[Point], color: Color) -> None:
    """A polygon of a lighter color with an outline."""
    pygame.draw.polygon(surface, _lighter(color), [*corners, corners[0]])
    for begin, end in zip(corners, corners[1:] + corners[:1]):
        _draw_line(surface, begin, end, color)


def _draw_line(surface: Any, begin: Point, end: Point, color: Color) -> None:
    """A line with round ends."""
    pygame.draw.lines(surface, color, False, [begin, end], 2 * LINE_RADIUS)
    across = (abs(end[1] - begin[1]), abs(end[0] - begin[0]))
    if across == (0, 0):
        return
    scale = LINE_RADIUS / (across[0] ** 2 + across[1] ** 2) ** 0.5
    x, y = round(across[0] * scale), round(across[1] * scale)
    outline = [
        (begin[0] - x, begin[1] - y),
        (begin[0] + x, begin[1] + y),
        (end[0] + x, end[1] + y),
        (end[0] - x, end[1] - y),
    ]
    pygame.draw.polygon(surface, color, outline)
    for point in (begin, end):
        pygame.draw.circle(surface, color, point, LINE_RADIUS)


def _goal() -> Any:
    """The goal on white: what is below pusher and tee."""
    surface = pygame.Surface((SIDE, SIDE), depth=32)
    surface.fill(WHITE)
    keypoints = gym_pusht_keypoints(np.array([[0.0, 0.0, 0.0, 0.0, *GOAL]]))
    for part in keypoints.reshape(2, 4, 2):
        corners = [_pixel(corner) for corner in part]
        pygame.draw.polygon(surface, LIGHT_GREEN, [*corners, corners[0]])
    return surface


def _walls() -> Any:
    """The walls: what is above pusher and tee."""
    surface = pygame.Surface((SIDE, SIDE), depth=32)
    surface.fill(CLEAR)
    surface.set_colorkey(CLEAR)
    for begin, end in WALLS:
        _draw_line(surface, begin, end, LIGHT_GRAY)
    return surface


_SURFACE = pygame.Surface((SIDE, SIDE), depth=32)
_BELOW = _goal()
_WALLS = _walls()
_STRIPS = (
    (0, 0, SIDE, 16),
    (0, SIDE - 16, SIDE, 16),
    (0, 0, 16, SIDE),
    (SIDE - 16, 0, 16, SIDE),
)


class Window:
    """A window that shows pictures at the speed of the world."""

    def __init__(self, frames_per_second: int) -> None:
        pygame.display.init()
        self._screen = pygame.display.set_mode((SIDE, SIDE))
        self._clock = pygame.time.Clock()
        self._frames_per_second = frames_per_second

    def show(self, surface: Any) -> None:
        """Shows a surface, at the next frame."""
        self._screen.blit(surface, (0, 0))
        pygame.event.pump()
        self._clock.tick(self._frames_per_second)
        pygame.display.update()

    def close(self) -> None:
        """Closes the window."""
        pygame.display.quit()
