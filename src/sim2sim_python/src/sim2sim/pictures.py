# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of gym-pusht's world, by the calls of pygame and OpenCV that gym-pusht makes.

Source: gym-pusht 0.1.5, pymunk 6.6's drawing for debugging. The same bytes as there with pygame 2.1
and OpenCV 4.6.

As a program it is a renderer of renderers.py: it answers questions from its standard input with
images on its standard output until its input ends. A question is three numbers, int64: how many
images, their width, their height [px]; then the NUMBERS of each, float64. The module imports
nothing of this package, so that a renderer starts fast.
"""

import math
import os
import sys
import threading
from typing import IO, Any, List, Tuple

import cv2  # type: ignore[import]
import numpy as np
import pygame
from numpy.typing import NDArray

VERSIONS = f"pygame {pygame.version.ver}, OpenCV {cv2.__version__}"

Point = Tuple[int, int]  # [px]
Color = Tuple[int, int, int]  # red, green, blue

NUMBERS = 18  # of an image: the pusher's position, the tee's corners (bar, then stem), x, y [px]
READY = b"r"  # first answer of a renderer

SIDE = 512  # [px]
PUSHER_RADIUS = 15  # [px]
PUSHER_RIM = 4  # [px]
LINE_RADIUS = 2  # [px] of walls, and of the tee's outline
BAR = ((-60, 30), (60, 30), (60, 0), (-60, 0))  # [px] corners from the tee's origin
STEM = ((-15, 30), (-15, 120), (15, 120), (15, 30))
GOAL_POSITION = (256.0, 256.0)  # [px]; the goal is turned by 45 degrees
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


def draw(numbers: NDArray[np.float64]) -> Any:
    """A surface [512 x 512] of the NUMBERS of an image. It is the thread's own, until it draws the
    next one."""
    surface = _CANVAS.surface
    surface.blit(_BELOW, (0, 0))
    for part in numbers[2:].reshape(2, 4, 2):
        _draw_polygon(surface, [_pixel(corner) for corner in part], LIGHT_SLATE_GRAY)
    center = _pixel(numbers[:2])
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


def images(rows: NDArray[np.float64], width: int, height: int) -> NDArray[np.uint8]:
    """Images [n, height, width, 3] of rows of NUMBERS [n, 18]."""
    drawn = np.empty((len(rows), height, width, 3), np.uint8)
    for image, row in zip(drawn, rows):
        image[:] = scaled(draw(row), width, height)
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
    for part in (BAR, STEM):
        corners = [_pixel(_at_goal(corner)) for corner in part]
        pygame.draw.polygon(surface, LIGHT_GREEN, [*corners, corners[0]])
    return surface


def _at_goal(point: Point) -> Tuple[float, float]:
    """A point of the tee where the tee is in the goal."""
    x, y = point
    across = math.sqrt(0.5)  # sine and cosine of 45 degrees
    return GOAL_POSITION[0] + across * (x - y), GOAL_POSITION[1] + across * (x + y)


def _walls() -> Any:
    """The walls: what is above pusher and tee."""
    surface = pygame.Surface((SIDE, SIDE), depth=32)
    surface.fill(CLEAR)
    surface.set_colorkey(CLEAR)
    for begin, end in WALLS:
        _draw_line(surface, begin, end, LIGHT_GRAY)
    return surface


class _Canvas(threading.local):
    """Surface on which a thread draws, in place of a new one for each image."""

    def __init__(self) -> None:
        self.surface = pygame.Surface((SIDE, SIDE), depth=32)


_CANVAS = _Canvas()
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


def serve(questions: IO[bytes], answers: IO[bytes]) -> None:
    """Answers questions until the input ends."""
    answers.write(READY)
    answers.flush()
    while sizes := questions.read(3 * 8):
        count, width, height = (int(size) for size in np.frombuffer(sizes, np.int64))
        rows = np.frombuffer(questions.read(count * NUMBERS * 8)).reshape(count, NUMBERS)
        answers.write(images(rows, width, height).data)
        answers.flush()


if __name__ == "__main__":
    cv2.setNumThreads(1)  # the other cores have renderers of their own
    try:
        serve(sys.stdin.buffer, sys.stdout.buffer)
    except BrokenPipeError:  # the parent process has ended
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
