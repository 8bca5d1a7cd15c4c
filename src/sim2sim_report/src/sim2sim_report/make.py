# SPDX-License-Identifier: BSD-3-Clause
"""The page and the figures that results call for."""

from pathlib import Path
from typing import List, Sequence, Tuple

from pusht_task.error import Error

from sim2sim_report.agreement import names_of, read_agreement
from sim2sim_report.attribution import draw as draw_attribution
from sim2sim_report.attribution import is_attributed, read_attribution
from sim2sim_report.curves import draw as draw_sweep
from sim2sim_report.equivalents import DRAWING as EQUIVALENTS
from sim2sim_report.equivalents import has_equivalents, read_equivalents
from sim2sim_report.figures import MARK, Drawing
from sim2sim_report.matrix import draw as draw_matrix
from sim2sim_report.matrix import has_matrix, read_matrix
from sim2sim_report.page import Page
from sim2sim_report.results import (
    is_partial,
    is_sweep,
    read_partial,
    read_run,
    read_traces,
)
from sim2sim_report.run_figures import draw, draw_rates
from sim2sim_report.suite import Suite

__all__ = ["MARK", "make"]


def make(
    folders: Sequence[Path], animate: Sequence[int], suite: Suite
) -> Tuple[str, List[Drawing]]:
    """The page of results, and the figures on it. Refuses what is not as this version writes it."""
    try:
        if len(folders) == 1 and folders[0].is_file():
            return _of_agreement(folders[0], animate, suite)
        if len(folders) == 1 and is_sweep(folders[0]):
            return _of_sweep(folders[0], animate, suite)
        if len(folders) == 1 and is_partial(folders[0]):
            if animate:
                raise Error(f"{folders[0]}: is a part of a run, which has no --animate")
            return Page(suite).of_partial(read_partial(folders[0])), []
        return _of_runs(folders, animate, suite)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        names = ", ".join(map(str, folders))
        raise Error(f"{names}: is not as this version writes it: {error!r}") from None
    except RecursionError:
        names = ", ".join(map(str, folders))
        raise Error(f"{names}: must have files that are less deeply nested") from None


def _of_agreement(file: Path, animate: Sequence[int], suite: Suite) -> Tuple[str, List[Drawing]]:
    if animate:
        raise Error(f"{file}: is an agreement, which has no --animate")
    figures = read_agreement(file)
    drawings = [figure.drawing(name) for name, figure in zip(names_of(figures), figures)]
    return Page(suite).of_agreement(file, figures, drawings), drawings


def _of_sweep(folder: Path, animate: Sequence[int], suite: Suite) -> Tuple[str, List[Drawing]]:
    if animate:
        raise Error(f"{folder}: is a sweep, which has no --animate")
    if has_matrix(folder):
        return Page(suite).of_matrix(folder), draw_matrix(read_matrix(folder))
    if is_attributed(folder):
        return Page(suite).of_attribution(folder), draw_attribution(read_attribution(folder))
    if has_equivalents(folder):
        return Page(suite).of_equivalents(folder), [read_equivalents(folder).drawing(EQUIVALENTS)]
    return Page(suite).of_sweep(folder), draw_sweep(folder, suite)


def _of_runs(
    folders: Sequence[Path], animate: Sequence[int], suite: Suite
) -> Tuple[str, List[Drawing]]:
    runs = [read_run(folder) for folder in folders]
    html = Page(suite).of_runs(runs, [read_traces(run, suite) for run in runs], animate)
    drawings = [draw_rates(runs)]
    for number, run in enumerate(runs):
        drawings += draw(run, f"{number}-" if len(runs) > 1 else "").values()
    return html, drawings
