# SPDX-License-Identifier: BSD-3-Clause
"""The figures of runs: success, mean divergences, divergence over time, and first causes."""

import functools
from typing import Any, Dict, List, Optional, Sequence, Tuple

from pusht_task.json_file import Json
from pusht_task.task import CONTROL_STEP

from sim2sim_report.colors import COLORS, DIM, INK
from sim2sim_report.figures import (
    COMPONENTS,
    NARROW,
    Drawing,
    draw_interval,
    name_rows,
    panels,
    wrapped,
)
from sim2sim_report.results import ENGINE, REPLAY, Run

LONGEST_LINE = 26  # characters of a name beside its bar
_LEVELS = ("0.05", "0.25", "0.50", "0.75", "0.95")  # levels of the bands


def draw(run: Run, prefix: str) -> Dict[str, Drawing]:
    """The figures of a run by name; `prefix` tells runs apart."""
    drawings = {}
    for name, alt, build in (
        ("yardsticks", _baselines_in_words(run), _baselines),
        ("divergence", "Quantiles of the divergence over time, with the bound", _bands),
        ("causes", "First causes: " + ", ".join(_named_causes(run)), _causes),
    ):
        drawings[name] = Drawing(f"{prefix}{name}", alt, functools.partial(build, run))
    return drawings


def draw_rates(runs: Sequence[Run], policies: Optional[Sequence[str]] = None) -> Drawing:
    """Success with intervals: the reference, and the engine of each run; of runs of several
    `policies` each policy in both."""
    bars = [(f"{runs[0].title('reference')}", runs[0].metrics, "reference")]
    bars += [(run.name, run.metrics, "engine") for run in runs]
    if policies:
        bars = [
            (f"{policy} in {run.title('reference') if role == 'reference' else run.name}", m, role)
            for policy, run in zip(policies, runs)
            for role, m in (("reference", run.metrics), ("engine", run.metrics))
        ]
    texts = [f"{name} {m[f'{role}_success_rate']:.3f}" for name, m, role in bars]

    def build(narrow: bool) -> Any:
        names = [wrapped(name, LONGEST_LINE) for name, _, _ in bars]
        lines = sum(name.count("\n") + 1 for name in names)
        height = 0.75 + 0.3 * len(bars) + 0.2 * lines
        figure, [[axes]] = panels(narrow, (1, 1), (5.6, height), (NARROW, height))
        for row, (_, metrics, role) in enumerate(bars):
            color = COLORS["reference"] if role == "reference" else COLORS[ENGINE]
            rate = metrics[f"{role}_success_rate"]
            _draw_share(axes, row, rate, metrics[f"{role}_success_interval"], color)
        name_rows(axes, names)
        axes.set_xlim(0, 1)
        axes.set_xlabel("success rate, closed loop")
        return figure

    return Drawing("success", "Success rates: " + ", ".join(texts), build)


def _baseline_rows(run: Run) -> List[Tuple[str, str, str, str]]:
    """Mean divergences and their baselines: name, mode, quantity, color."""
    rows = [
        ("open loop", REPLAY, "mean_{}_divergence", COLORS[REPLAY]),
        ("its null model", REPLAY, "null_{}_divergence", DIM),
        ("closed loop", ENGINE, "mean_{}_divergence", COLORS[ENGINE]),
        ("its null model", ENGINE, "null_{}_divergence", DIM),
    ]
    rows += [
        (f"floor, {name[len('floor_'):]} m", name, "mean_{}_divergence", COLORS["reference"])
        for name in reversed(run.metrics["probes"])
        if name.startswith("floor_")
    ]
    return rows


def _baselines_in_words(run: Run) -> str:
    parts = []
    for name, mode, quantity, _ in _baseline_rows(run):
        mean = run.statistics["rollouts"][mode][f"{quantity.format('position')}_m"]["mean"]
        parts.append(f"{name} {'none' if mean is None else format(mean, '.4f')} m")
    return "Mean divergences with null model and floor: " + ", ".join(parts)


def _baselines(run: Run, narrow: bool) -> Any:
    """Mean divergences beside their baselines, from zero, with their values."""
    rows = _baseline_rows(run)
    height = 0.8 + 0.32 * len(rows)
    figure, [both] = panels(narrow, (1, 2), (8.6, height), (NARROW, height), sharey=True)
    for axes, (component, unit) in zip(both, COMPONENTS):
        end = 0.0
        for row, (_, mode, quantity, color) in enumerate(rows):
            figures = run.statistics["rollouts"][mode][f"{quantity.format(component)}_{unit}"]
            if figures["mean"] is None:
                continue
            right = figures["mean"]
            if figures["mean_interval"] is not None:
                draw_interval(axes, figures["mean_interval"], row, color=color, linewidth=3)
                right = max(right, figures["mean_interval"][1])
            axes.plot(figures["mean"], row, "o", color=color, markersize=7, clip_on=False)
            text = (6, 0)  # [points] to the right of the interval
            axes.annotate(
                f"{figures['mean']:.4f}",
                (right, row),
                text,
                va="center",
                fontsize=10,
                textcoords="offset points",
                color=INK,
            )
            end = max(end, right)
        axes.set_xlim(0, 1.25 * (end or 1.0))
        axes.locator_params(axis="x", nbins=5)
        axes.set_xlabel(f"{component} [{unit}]")
        name_rows(axes, [row[0] for row in rows])
    return figure


def _bands(run: Run, narrow: bool) -> Any:
    """Quantiles of the divergence over time, and how many episodes they are of."""
    ratios = [3, 3, 1.2] * (2 if narrow else 1)
    shared = {"sharex": True, "sharey": "row", "height_ratios": ratios}
    figure, grid = panels(narrow, (3, 2), (8.6, 5.0), (NARROW, 8.6 / 6), by_column=True, **shared)
    bound = run.metrics["bound"]
    limits = {"position": bound["position_m"], "angle": bound["angle_rad"]}
    for column, (mode, name) in enumerate(((REPLAY, "open loop"), (ENGINE, "closed loop"))):
        band, color = run.bands[mode], COLORS[mode]
        seconds = band["step"] * CONTROL_STEP
        grid[0, column].set_title(name, color=INK, fontsize=12, loc="left")
        for axes, (component, unit) in zip(grid[:, column], COMPONENTS):
            levels = [band[f"{component}_{level}_{unit}"] for level in _LEVELS]
            axes.fill_between(seconds, levels[0], levels[4], color=color, alpha=0.15, linewidth=0)
            axes.fill_between(seconds, levels[1], levels[3], color=color, alpha=0.3, linewidth=0)
            axes.plot(seconds, levels[2], color=color)
            axes.axhline(limits[component], color=INK, linewidth=1, linestyle="--")
            axes.set_ylim(bottom=0)
            if column == 0 or narrow:
                axes.set_ylabel(f"{component} [{unit}]")
        running = grid[2, column]
        running.fill_between(seconds, band["episodes"], step="post", color=DIM, alpha=0.4)
        running.set_ylim(bottom=0)
        running.locator_params(axis="y", nbins=2, integer=True)
        if column == 0 or narrow:
            running.set_ylabel("episodes")
        if column == 1 or not narrow:
            running.set_xlabel("time [s]")
    return figure


def _causes_of(run: Run) -> List[Tuple[str, Json]]:
    """Causes of first divergence in open loop, the most frequent first."""
    causes: Json = run.statistics["rollouts"][REPLAY]["parting"]["causes"]
    return sorted(
        ((name, cause) for name, cause in causes.items() if cause["episodes"]),
        key=lambda item: (-int(item[1]["episodes"]), item[0]),
    )


def _named_causes(run: Run) -> List[str]:
    return [f"{name.replace('_', ' ')}: {cause['episodes']}" for name, cause in _causes_of(run)]


def _causes(run: Run, narrow: bool) -> Any:
    """Causes of first divergence, with the share of episodes that each has."""
    shown = _causes_of(run)
    height = 0.9 + 0.36 * max(1, len(shown))
    figure, [[axes]] = panels(narrow, (1, 1), (6.2, height), (NARROW, height))
    for row, (_, cause) in enumerate(shown):
        _draw_share(axes, row, cause["share"], cause.get("interval"), COLORS[REPLAY])
    name_rows(axes, _named_causes(run))
    axes.set_xlim(0, 1)
    axes.set_xlabel(
        "share of the first divergences" if narrow else "share of the first divergences, open loop"
    )
    return figure


def causes_have_intervals(run: Run) -> bool:
    return any(cause.get("interval") is not None for _, cause in _causes_of(run))


def _draw_share(
    axes: Any, row: int, share: float, interval: Optional[Sequence[float]], color: str
) -> None:
    axes.barh(row, share, height=0.55, color=color, alpha=0.85)
    draw_interval(axes, interval, row, color=INK, linewidth=2.5, solid_capstyle="butt")
