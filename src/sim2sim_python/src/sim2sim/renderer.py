# SPDX-License-Identifier: BSD-3-Clause
"""Program that draws images for renderers.py: it reads states from its standard input, writes their
images to its standard output, and ends with its input.

A question is three numbers, int64: how many images, their width, their height [px]; then a state
for each, NUMBERS x float64. The answer is the images, one after the other.
"""

import os
import sys
from typing import IO

import numpy as np

from sim2sim import pictures
from sim2sim.renderers import NUMBERS, READY


def serve(questions: IO[bytes], answers: IO[bytes]) -> None:
    """Draws what is asked for until nothing comes any more."""
    answers.write(READY)
    answers.flush()
    while sizes := questions.read(3 * 8):
        count, width, height = (int(size) for size in np.frombuffer(sizes, np.int64))
        states = np.frombuffer(questions.read(count * NUMBERS * 8)).reshape(count, NUMBERS)
        answers.write(pictures.images(states, width, height).tobytes())
        answers.flush()


if __name__ == "__main__":
    try:
        serve(sys.stdin.buffer, sys.stdout.buffer)
    except BrokenPipeError:  # who asked has ended
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
