# SPDX-License-Identifier: BSD-3-Clause
"""The page: what results say, in words and figures. It computes nothing; it rounds and arranges."""

import json
from pathlib import Path
from typing import Any, List, Optional, Sequence

import jinja2
from pusht_task.error import Error
from pusht_task.json_file import Json

from sim2sim_report import agreement_tables, audit, colors, equivalents, run_figures
from sim2sim_report.again import command_of, notes_on_command, suggested_attribution
from sim2sim_report.agreement import AgreementFigure
from sim2sim_report.animation import GEOMETRY, animated, geometry_of, player, poster
from sim2sim_report.attribution import read_attribution
from sim2sim_report.cause import section as attribution_section
from sim2sim_report.curves import draw as draw_sweep
from sim2sim_report.figures import Drawing
from sim2sim_report.matrix import read_matrix
from sim2sim_report.matrix_tables import headline as matrix_headline
from sim2sim_report.matrix_tables import section as matrix_section
from sim2sim_report.results import KINDS, QUESTION, Partial, Run, Traces, read_sweep
from sim2sim_report.sentences import CAUTION, cautions, first_divergence, sentences, sweep_summary
from sim2sim_report.suite import Suite
from sim2sim_report.sweep_rows import TRANSFER, panels_of
from sim2sim_report.tables import (
    contrast_rows,
    divergences,
    episode_row,
    parameters,
    stuck_texts,
    sweep_row,
)
from sim2sim_report.words import glossary

ROWS_WITHOUT_SCRIPT = 100  # episodes in the table of a page in which no script runs
KIND_NAMES = {
    "only_reference_succeeds": "reference only",
    "both_succeed": "both",
    "neither_succeeds": "neither",
    "only_engine_succeeds": "engine only",
}


class Page:
    """Templates and what every page shares."""

    def __init__(self, suite: Suite) -> None:
        self.suite = suite
        here = Path(__file__).parent
        self.environment = jinja2.Environment(
            autoescape=True,
            loader=jinja2.FileSystemLoader(str(here)),
            trim_blocks=True,
            lstrip_blocks=True,
            undefined=jinja2.StrictUndefined,
        )
        self.environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "sort_keys": True}
        self.shared = {
            "css": jinja2.utils.markupsafe.Markup(
                colors.css() + (here / "page.css").read_text("utf-8")
            ),
            "script": jinja2.utils.markupsafe.Markup((here / "page.js").read_text("utf-8")),
            "matrix_script": jinja2.utils.markupsafe.Markup(
                (here / "matrix.js").read_text("utf-8")
            ),
            "words": glossary(),
            "geometry": GEOMETRY,
            "kind_names": KIND_NAMES,
        }

    def of_runs(
        self, runs: Sequence[Run], traces: Sequence[Optional[Traces]], animate: Sequence[int]
    ) -> str:
        """Page of a run, or of several over the same episodes, which are held against the first."""
        folders = [run.folder for run in runs]
        compared = self.suite.contrast(folders) if len(runs) > 1 else {}
        names = names_of(runs, compared)
        what = "policies" if of_policies(compared) else "engines"
        engines = runs[0].name if len(runs) == 1 else f"{len(runs)} {what}, pair by pair"
        answers = [{"name": name, "answer": run.answer} for name, run in zip(names, runs)]
        audits = [audit.section(run.folder, run.metrics["simulators"]) for run in runs]
        broken = [line for found in audits for line in audit.caution(found)]
        return self._render(
            title=f"{runs[0].title('reference')} to {engines}",
            question=compared["headline"]["question"] if compared else runs[0].question,
            caveat=next((_caveat(*it, compared) for it in zip(names, runs) if it[1].caveat), ""),
            headline=compared["headline"]["answer"] if compared else runs[0].answer,
            answers=answers if len(runs) > 1 else [],
            caution=broken + cautions([run.metrics for run in runs]),
            rates=run_figures.draw_rates(runs, names if of_policies(compared) else None),
            contrasts=[contrast_rows(c) for c in compared.get("contrasts", [])],
            contrasted="policy" if of_policies(compared) else "engine",
            baseline=names[0],
            geometry=geometry_of(runs[0]),
            runs=[
                {**_section(run, number, shown, animate), "name": name, "audit": found}
                for number, (run, name, shown, found) in enumerate(zip(runs, names, traces, audits))
            ],
        )

    def of_sweep(self, folder: Path) -> str:
        """Curves over every parameter that varies, and every row against the first."""
        content = read_sweep(folder)
        rows, whole = content["rows"], len(content["sweep"]["rows"])
        if len(rows) < whole:
            unfinished = f"is unfinished: {len(rows)} of {whole} rows; `sweep` goes on with it"
            raise Error(f"{folder}: {unfinished}")
        if panels_of(rows)[0] is TRANSFER:
            raise Error(f"{folder}: has several loops; `plot_sweep` draws it")
        curves, pairs = draw_sweep(folder, self.suite)
        compared = self.suite.contrast([folder])
        return self._render(
            title=f"Sweep {folder.resolve().name}",
            question=compared["headline"]["question"],
            headline=compared["headline"]["answer"],
            caution=cautions(rows),
            contrasts=[contrast_rows(c) for c in compared["contrasts"]],
            baseline=compared["baseline"]["title"],
            sweep={
                "curves": curves,
                "pairs": pairs,
                "summary": sweep_summary(rows[0]),
                "rows": [sweep_row(folder, number, row) for number, row in enumerate(rows)],
                "attribute": suggested_attribution(folder, rows),
            },
        )

    def of_attribution(self, folder: Path) -> str:
        """A sweep over switches of which the cause of the gap is known."""
        attribution = read_attribution(folder)
        section = attribution_section(attribution)
        return self._render(
            title=f"Sweep {folder.resolve().name}",
            question="What causes the gap?",
            headline=section["headline"],
            caution=[*section["caution"], *CAUTION],
            attribution=section,
        )

    def of_equivalents(self, folder: Path) -> str:
        """A sweep over engines and errors of the reference, held against each other."""
        section = equivalents.section(equivalents.read_equivalents(folder))
        return self._render(
            title=f"Sweep {folder.resolve().name}",
            question=f"Which error of {section['reference']} costs as much as an engine?",
            headline=section["headline"],
            caution=[CAUTION[0]],
            equivalents=section,
        )

    def of_matrix(self, folder: Path) -> str:
        """A sweep over policies of which the matrix is known."""
        matrix = read_matrix(folder)
        section = matrix_section(matrix, folder)
        return self._render(
            title=f"Policies by simulators, {folder.resolve().name}",
            question="Does the verdict hold for other policies?",
            headline=matrix_headline(matrix),
            caution=[*section["caution"], CAUTION[0]],
            matrix=section,
        )

    def of_agreement(
        self, file: Path, found: Sequence[AgreementFigure], drawings: Sequence[Drawing]
    ) -> str:
        """Distances of all pairs of simulators."""
        section = agreement_tables.section(found, drawings)
        return self._render(
            title=f"Agreement of simulators, {file.stem}",
            question="Which simulators agree?",
            headline=agreement_tables.headline(found),
            caution=[*section["caution"], CAUTION[0]],
            agreement=section,
        )

    def of_partial(self, partial: Partial) -> str:
        """A run that was interrupted, or failed: its episodes, without figures."""
        status, configuration = partial.status, partial.provenance["configuration"]
        count = f"{len(partial.episodes)} of {status['episodes']} episodes"
        audited = audit.section(partial.folder, configuration["simulators"])
        return self._render(
            title=f"{partial.title('reference')} to {partial.title('engine')}",
            question=QUESTION,
            headline="Cannot say yet: the run has not finished.",
            unfinished=f"{count}; {status['reason']}",
            caution=[
                *audit.caution(audited),
                "A part of a run has no figures here: which episodes have finished may hang on how "
                "long they are.",
                *CAUTION,
            ],
            partial={
                "id": "run0",
                "policy": configuration["policy"],
                "reference": partial.title("reference"),
                "engine": partial.title("engine"),
                "audit": audited,
                "counts": partial.counts,
                "stuck": stuck_texts(partial.episodes),
                "episodes": len(partial.episodes),
                "table": [episode_row(e) for e in partial.episodes],
                "player": None,
                "command": command_of(partial),
                "notes": notes_on_command(partial),
                "provenance": json.dumps(partial.provenance, indent=2, sort_keys=True),
            },
        )

    def _render(self, **context: Any) -> str:
        for name in (
            "rates",
            "sweep",
            "attribution",
            "equivalents",
            "matrix",
            "agreement",
            "partial",
            "unfinished",
        ):
            context.setdefault(name, None)
        for name in ("answers", "contrasts", "runs"):
            context.setdefault(name, [])
        for name in ("baseline", "caveat"):
            context.setdefault(name, "")
        context.setdefault("contrasted", "engine")
        rows = ROWS_WITHOUT_SCRIPT
        template = self.environment.get_template("page.html.j2")
        return template.render(rows_without_script=rows, **{**self.shared, **context})


def of_policies(compared: Json) -> bool:
    """Whether what `contrast` says is of several policies, not engines."""
    return "policy" in compared.get("baseline", {})


def names_of(runs: Sequence[Run], compared: Json) -> List[str]:
    """The names that tell runs apart: their policies as `contrast` has them, or their engines."""
    if of_policies(compared):
        return [compared["baseline"]["title"], *(c["title"] for c in compared["contrasts"])]
    return [run.name for run in runs]


def _caveat(name: str, run: Run, compared: Json) -> str:
    """The caveat of a run, with its policy where there are several."""
    return f"{name}: {run.caveat}" if of_policies(compared) else run.caveat


def _section(run: Run, number: int, traces: Optional[Traces], animate: Sequence[int]) -> Json:
    shown = animated(run, animate)
    return {
        "id": f"run{number}",
        "folder": run.folder.resolve().name,
        "reference": run.title("reference"),
        "engine": run.name,
        "metrics": run.metrics,
        "counts": {kind: run.metrics[kind] for kind in KINDS.values()},
        "stuck": stuck_texts(run.episodes),
        "episodes": run.metrics["episodes"],
        "answer": run.answer,
        "sentences": sentences(run),
        "divergences": divergences(run),
        "has_intervals": run.metrics["mean_pos_divergence_median_interval_m"] is not None,
        "drawings": run_figures.draw(run, f"run{number}-"),
        "causes_have_intervals": run_figures.causes_have_intervals(run),
        "first_divergence": first_divergence(run),
        "parameters": parameters(run),
        "provenance": json.dumps(run.provenance, indent=2, sort_keys=True),
        "command": command_of(run),
        "notes": notes_on_command(run),
        "animated": len(shown),
        "player": None if traces is None else player(run, traces, shown),
        "poster": None if traces is None else poster(run, traces),
        "table": [episode_row(e) for e in run.episodes],
    }
