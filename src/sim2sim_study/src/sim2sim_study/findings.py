# SPDX-License-Identifier: BSD-3-Clause
"""Tables and pictures of the study over policies, from its results."""

import math
from functools import partial
from pathlib import Path
from typing import Dict, Iterator, List, Optional, Sequence, Tuple

import numpy as np
from pusht_task.json_file import read_json
from scipy import stats  # type: ignore[import]
from sim2sim_protocol.result_files import name_of
from sim2sim_report.results import read_rows

from sim2sim_study import statistics
from sim2sim_study.conduct import HOME, conduct_runs, policy_conduct
from sim2sim_study.curves import draw_epochs, write_curves
from sim2sim_study.plan import Plan, first_policies
from sim2sim_study.tables import Row, nested, write_figures, write_table

NEAR = (0.1, 0.2)  # [m], [rad]: a failure within these of the goal ends near it
LADDER_GAPS = ("mean_pos_divergence", "lost_success")
SIGNIFICANT = 0.05  # after Holm


def write_findings(plan: Plan, work: Path, tables: Path) -> None:
    """Writes groups.csv, curves.csv and .png, failures.csv, rankings.csv, ladder.csv,
    ladder_ranks.csv, variants.csv, conduct.csv and predictions.csv; and figures.json, which has
    what docs/claims.yaml reads."""
    matrix = read_json(work / "matrix.json")
    groups = list(group_rows(matrix))
    curve = list(_curve_rows(plan, groups))
    write_table(tables / "groups.csv", groups)
    write_table(tables / "curves.csv", curve)
    failures = _failure_rows(plan, matrix, work)
    write_table(tables / "failures.csv", failures)
    rankings = list(_ranking_rows(read_json(work / "rankings.json")))
    write_table(tables / "rankings.csv", rankings)
    shares = _ladder_shares(plan, work)
    ladder = _ladder_rows(shares)
    ranks = _ladder_ranks(shares)
    write_table(tables / "ladder.csv", ladder)
    write_table(tables / "ladder_ranks.csv", ranks)
    variants = list(_variant_rows(read_json(work / "variants.json")))
    write_table(tables / "variants.csv", variants)
    explored, tested = _conduct(plan, work)
    conduct = [*_conduct_rows("explored", explored), *_conduct_rows("tested", tested)]
    predictions = _prediction_rows(plan["conduct"]["predictions"], tested)
    write_table(tables / "conduct.csv", conduct)
    write_table(tables / "predictions.csv", predictions)
    figures = {
        "hypotheses": {h["name"].partition(" ")[0]: h for h in matrix["hypotheses"]},
        "groups": nested(groups, "group", "simulator"),
        "failures": nested(failures, "group"),
        "rankings": nested(rankings, "there", "figure"),
        "ladder": nested(ladder, "gap", "group", "switch"),
        "ladder_ranks": nested(ranks, "gap", "policies of"),
        "variants": nested(variants, "simulator", "figure", "policies of"),
        "conduct": nested(conduct, "trainings", "group", "simulator", "figure"),
        "predictions": nested(predictions, "prediction"),
        "spread": {name: _spread_of(work / f"{name}.json") for name in plan["matrices"]},
    }
    write_figures(tables / "figures.json", figures)
    write_curves(tables / "curves.png", "Success over epochs", partial(draw_epochs, curve))


def _spread_of(path: Path) -> Row:
    """Shares of the variance of cells, by figure and source."""
    spreads = read_json(path)["spreads"]
    return {
        spread["figure"]: {source["source"]: source["share"] for source in spread["sources"]}
        for spread in spreads
    }


def _estimate(name: str, found: Row) -> Row:
    low, high = found["interval"] or ("", "")
    return {name: found["value"], f"{name}_low": low, f"{name}_high": high}


def group_rows(matrix: Row) -> Iterator[Row]:
    """Each group of policies in each simulator."""
    for group in matrix["groups"]:
        for simulator, cell in zip(matrix["simulators"], group["cells"]):
            if cell:
                yield {
                    "group": group["group"],
                    "simulator": simulator["name"],
                    "policies": cell["policy_count"],
                    **_estimate("success", cell["success_rate"]),
                    "between_policies": cell["between_policies"],
                    **_estimate("transfer", cell["transfer"]),
                    **_estimate(
                        "early_position_divergence_m",
                        cell["divergence"]["early_position_divergence"],
                    ),
                }


def _curve_rows(plan: Plan, groups: Sequence[Row]) -> Iterator[Row]:
    """Success of the trainings that have policies after several epochs."""
    for name, group in plan["groups"].items():
        epochs = group.get("also_after", [])
        last = plan["recipes"][group["recipe"]]["epochs"]
        named = {f"after-{count}-{name}": count for count in epochs}
        named[name] = last
        for row in groups:
            if epochs and row["group"] in named:
                keys = ("simulator", "policies", "success", "success_low", "success_high")
                values = {key: row[key] for key in keys}
                yield {"training": name, "epochs": named[row["group"]], **values}


def _ranking_rows(matrix: Row) -> Iterator[Row]:
    """How far the order of policies in the home holds elsewhere, and from which difference on."""
    names = [simulator["name"] for simulator in matrix["simulators"]]
    for ranking in matrix["rankings"]:
        if names[ranking["reference"]] != HOME:
            continue
        of = {"there": names[ranking["test"]], "policies": ranking["policy_count"]}
        for figure in ("kendall", "spearman", "pearson", "mean_maximum_rank_violation"):
            yield {**of, "figure": figure, "pairs": "", **_estimate("value", ranking[figure])}
        for share in ranking["agreement"]:
            figure = f"better in both, success differs by {share['from']} to {share['to']}"
            yield {**of, "figure": figure, "pairs": share["pairs"], **_estimate("value", share)}


def _failure_rows(plan: Plan, matrix: Row, work: Path) -> List[Row]:
    """Share of the failures at home that ends near the goal, by group of that home, and the
    difference of two groups. A policy that never fails has no share."""
    home = [simulator["name"] for simulator in matrix["simulators"]].index(HOME)
    rows = []
    of_group: Dict[str, List[float]] = {}
    for group in matrix["groups"]:
        members = [matrix["policies"][policy] for policy in group["policies"]]
        if any(policy["reference"] != home for policy in members):
            continue
        found = [_near_share(work / "matrix" / policy["cells"][home]["row"]) for policy in members]
        shares = [share for share in found if share is not None]
        if shares:
            of_group[group["group"]] = shares
            rows.append(
                {"group": group["group"], "policies": len(shares), **statistics.mean(shares)}
            )
    more, less = plan["failures"]["more"], plan["failures"]["less"]
    both = of_group.get(more, []), of_group.get(less, [])
    if all(both):
        count = sum(map(len, both))
        rows.append(
            {"group": f"{more} less {less}", "policies": count, **statistics.difference(*both)}
        )
    return rows


def _near_share(folder: Path) -> Optional[float]:
    failures = [
        row
        for row in read_rows(folder / name_of("episodes"))
        if row["mode"] == "reference_closed" and row["success"] == "false"
    ]
    near = [
        float(row["final_position_error_m"]) <= NEAR[0]
        and float(row["final_angle_error_rad"]) <= NEAR[1]
        for row in failures
    ]
    return float(np.mean(near)) if near else None


Shares = Dict[Tuple[str, str], List[Dict[str, float]]]  # by group and gap; a policy each


def _ladder_shares(plan: Plan, work: Path) -> Shares:
    """How much of a gap each switch closes, for each policy of the ladder."""
    shares: Shares = {}
    for group, name in first_policies(plan, plan["ladder"]):
        rows = read_rows(work / f"ladder-{name}" / name_of("attribution_table"))
        for gap in LADDER_GAPS:
            found = {row["switch"]: float(row["share"]) for row in rows if row["gap"] == gap}
            of_switches = {s: found[s] for s in plan["ladder"]["switches"]}
            shares.setdefault((group, gap), []).append(of_switches)
    return shares


def _ladder_rows(shares: Shares) -> List[Row]:
    """Mean share of each switch over the policies of a group, and of all switches, which is the
    gap; and what each group's is beyond that of the group before."""
    columns = {
        key: {
            **{switch: [policy[switch] for policy in policies] for switch in policies[0]},
            "all": [sum(policy.values()) for policy in policies],
        }
        for key, policies in shares.items()
    }
    rows: List[Row] = []
    for (group, gap), column in columns.items():
        for switch, values in column.items():
            rows.append({"group": group, "gap": gap, "switch": switch, **statistics.mean(values)})
    compared: List[Row] = []
    for gap in dict.fromkeys(gap for _, gap in columns):
        groups = [group for group, of in columns if of == gap]
        for less, more in zip(groups, groups[1:]):
            for switch, values in columns[more, gap].items():
                found = statistics.difference(values, columns[less, gap][switch])
                p = statistics.difference_p(values, columns[less, gap][switch])
                named = {"group": f"{more} less {less}", "gap": gap, "switch": switch}
                compared.append({**named, **found, "p": p})
    switches = [row for row in compared if row["switch"] != "all"]
    for row, adjusted in zip(switches, statistics.holm([row["p"] for row in switches])):
        row["adjusted_p"] = adjusted
    return [
        {**row, **{key: row.get(key, "") for key in ("p", "adjusted_p")}}
        for row in [*rows, *compared]
    ]


def _ladder_ranks(shares: Shares) -> List[Row]:
    """Kendall's W of the switches' shares: 1 if all policies rank them alike. Its p-value is that
    of Friedman's test of ranks without any order."""
    rows: List[Row] = []
    for gap in LADDER_GAPS:
        for name in ["all", *(group for group, of in shares if of == gap)]:
            policies = [
                list(policy.values())
                for (group, of), found in shares.items()
                if of == gap and name in ("all", group)
                for policy in found
            ]
            w, p = float("nan"), float("nan")
            if len(policies) > 1 and len(policies[0]) > 2:
                chi_square, p = stats.friedmanchisquare(*np.array(policies).T)
                w = chi_square / (len(policies) * (len(policies[0]) - 1))
            counted: Row = {"gap": gap, "policies of": name, "policies": len(policies)}
            rows.append({**counted, "kendall_w": w, "p": p})
    return rows


def _variant_rows(matrix: Row) -> Iterator[Row]:
    """How much success differs from that in the home, and in how many episodes the outcome is the
    same, for policies of all groups and of each."""
    names = [simulator["name"] for simulator in matrix["simulators"]]
    home = names.index(HOME)
    for there, name in enumerate(names):
        if there == home:
            continue
        differences: Dict[str, List[float]] = {"all": []}
        alike: Dict[str, List[float]] = {"all": []}
        for policy in matrix["policies"]:
            won, won_home = (
                np.array(list(policy["cells"][s]["success_by_episode"])) == "1"
                for s in (there, home)
            )
            for group in ("all", policy["group"]):
                differences.setdefault(group, []).append(float(won.mean() - won_home.mean()))
                alike.setdefault(group, []).append(float(np.mean(won == won_home)))
        for figure, found in (("success_difference", differences), ("alike", alike)):
            for group, values in found.items():
                of = {"simulator": name, "figure": figure, "policies of": group}
                yield {**of, "policies": len(values), **statistics.mean(values)}


Conduct = Dict[Tuple[str, str, str], List[float]]  # by group, simulator, figure; a training each


def _conduct(plan: Plan, work: Path) -> Tuple[Conduct, Conduct]:
    """What policies do, of the trainings that were explored, and of those that the predictions are
    tested on."""
    explored: Conduct = {}
    tested: Conduct = {}
    part = plan["conduct"]
    for group, seed, name in conduct_runs(plan):
        conduct = explored if seed < plan["first_seed"] + part["explored"] else tested
        found = policy_conduct(work / "conduct" / name, part["engine"])
        for (simulator, figure), value in found.items():
            conduct.setdefault((group, simulator, figure), []).append(value)
    return explored, tested


def _conduct_rows(trainings: str, conduct: Conduct) -> Iterator[Row]:
    for (group, simulator, figure), values in conduct.items():
        names = {"trainings": trainings, "group": group, "simulator": simulator, "figure": figure}
        yield {**names, "policies": len(values), **statistics.mean(values)}


def _prediction_rows(predictions: Row, conduct: Conduct) -> List[Row]:
    """The difference of two groups that each prediction is about, and its verdict after Holm."""
    rows: List[Row] = []
    for name, asked in predictions.items():
        more, less = (conduct[asked[s], asked["in"], asked["figure"]] for s in ("more", "less"))
        if asked.get("paired"):  # the same trainings
            found = statistics.mean([a - b for a, b in zip(more, less)])
            p = float(stats.ttest_rel(more, less).pvalue) if len(more) > 1 else math.nan
        else:
            found = statistics.difference(more, less)
            p = statistics.difference_p(more, less)
        of = {"prediction": name.partition(" ")[0], "says": name.partition(" ")[2]}
        side = {"side": asked["side"], "policies": len(more) + len(less)}
        rows.append({**of, **side, **found, "p": p})
    for row, adjusted in zip(rows, statistics.holm([row["p"] for row in rows])):
        is_expected = (row["mean"] > 0.0) == (row["side"] == "above")
        verdict = "holds" if is_expected else "contradicted"
        row["adjusted_p"] = adjusted
        row["verdict"] = verdict if adjusted < SIGNIFICANT else "not shown"
    return rows
