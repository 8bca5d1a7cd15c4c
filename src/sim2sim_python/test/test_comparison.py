#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""compare() in Python: the command's bytes and words, and what a Python callable may do."""

import contextlib
import io
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import unittest
import warnings
from functools import partial
from pathlib import Path
from typing import Any, Callable, Dict, List, Set, Tuple

import numpy as np
import sim2sim
import torch
from catkin.find_in_workspaces import find_in_workspaces  # type: ignore[import]
from numpy.typing import NDArray

REPORT: str = find_in_workspaces(["libexec"], "sim2sim_eval", "report", first_match_only=True)[0]
COMPARE: str = find_in_workspaces(["libexec"], "sim2sim_eval", "compare", first_match_only=True)[0]
DEADLINE = 240  # [s] for one command
TRIALS, TRIED = 3, 19  # calls before a run, and rows in them
SHORT: Dict[str, Any] = {"engine": "two_mass", "episodes": 4, "horizon": 30, "floor": False}
Rows = NDArray[np.float32]


def charge(observations: Rows) -> Rows:
    """Straight at the tee; a row's action has the same bits whatever rows are beside it."""
    return np.clip(5.0 * (observations[:, 2:4] - observations[:, 0:2]), -1.0, 1.0)


class Counting:
    """Counts, in the memory of each rollout, and steers by the count and by the seed."""

    def __init__(self) -> None:
        self.seeds: List[int] = []

    def begin(self, seed: int) -> Dict[str, int]:
        self.seeds.append(seed)
        return {"seed": seed, "calls": 0}

    def act(self, observations: Rows, memories: List[Dict[str, int]]) -> Rows:
        actions = np.zeros((len(observations), 2), np.float32)
        for action, memory in zip(actions, memories):
            action[:] = (memory["seed"] % 1000 / 1000.0, memory["calls"] / 100.0)
            memory["calls"] += 1
        return actions


class Noisy(torch.nn.Module):
    """Towards the tee, by where it was a step ago, and by noise: four steps."""

    def forward(self, observations: torch.Tensor, noise: torch.Tensor) -> torch.Tensor:
        way = observations[:, 0, 2:4] - observations[:, 1, 0:2]
        return (5.0 * way + 0.2 * noise).unsqueeze(1).repeat(1, 4, 1)


class ComparisonCase(unittest.TestCase):
    """In a folder of its own, which is the current one."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)
        self.folder = Path(folder.name)

    def command(self, *arguments: str, folder: str = ".") -> "subprocess.CompletedProcess[str]":
        return subprocess.run(
            [COMPARE, *arguments],
            cwd=self.folder / folder,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
        )

    def succeed(self, *arguments: str) -> str:
        process = self.command(*arguments)
        self.assertEqual(process.returncode, 0, process.stderr)
        return process.stdout

    def files(self, out: str) -> Dict[str, bytes]:
        return {file.name: file.read_bytes() for file in (self.folder / out).iterdir()}

    def load(self, out: str, name: str) -> Dict[str, Any]:
        content: Dict[str, Any] = json.loads((self.folder / out / name).read_text())
        return content

    def refused(self, line: str, call: Callable[[], object], code: int = 2) -> str:
        with self.assertRaisesRegex(sim2sim.Error, line) as caught:
            call()
        self.assertEqual(caught.exception.exit_code, code)  # type: ignore[attr-defined]
        self.assertNotIn("\n", str(caught.exception))
        return str(caught.exception)


class Bytes(ComparisonCase):
    def test_a_policy_by_name_gives_the_files_of_the_command(self) -> None:
        said = self.succeed("--episodes", "20", "--seed", "3", "--out", "by_command")
        results = sim2sim.compare("bc", episodes=20, seed=3, out="in_python")
        self.assertEqual(self.files("in_python"), self.files("by_command"))
        self.assertEqual(results.text, said.replace("by_command", "in_python"))
        self.assertEqual(str(results), results.text)
        self.assertEqual(results.folder, Path("in_python"))
        self.assertEqual(results.summary, self.load("by_command", "metrics.json"))
        self.assertEqual(results.provenance, self.load("by_command", "provenance.json"))

    def test_a_callable_that_is_the_shipped_policy_gives_its_bytes(self) -> None:
        self.succeed("--episodes", "24", "--out", "by_command")
        of_command = self.files("by_command")
        shipped = sim2sim.load_policy("bc")

        def wrapped(observations: Rows) -> Rows:
            return shipped(observations)

        for name, policy, threads in (
            ("one", wrapped, 1),
            ("two", wrapped, 2),
            ("all", shipped, None),
        ):
            with self.subTest(name):
                sim2sim.compare(policy, episodes=24, threads=threads, out=name)
                found = self.files(name)
                for file in ("episodes.csv", "statistics.json", "divergence.csv"):
                    self.assertEqual(found[file], of_command[file], file)
                metrics = self.load(name, "metrics.json")
                self.assertEqual(
                    {**metrics, "policy": "bc"}, self.load("by_command", "metrics.json")
                )

    def test_a_policy_with_a_memory_gives_its_bytes(self) -> None:
        self.succeed("--policy", "expert", "--episodes", "12", "--out", "by_command")
        expert = sim2sim.load_policy("expert")
        for threads in (1, 2):
            sim2sim.compare(expert, episodes=12, threads=threads, out=f"{threads}")
            self.assertEqual(
                self.files(f"{threads}")["episodes.csv"], self.files("by_command")["episodes.csv"]
            )
        self.refused("^policy expert: has a memory", lambda: expert(np.zeros((1, 10), np.float32)))

    def test_a_policy_with_history_chunks_and_noise_gives_its_bytes(self) -> None:
        description: Dict[str, Any] = {"format": 1, "observations": 2, "actions": 4, "execute": 2}
        description["noise"] = {"shape": [2], "distribution": "normal"}
        extra = {"policy.json": json.dumps(description)}
        torch.jit.save(torch.jit.script(Noisy()), "noisy.pt", _extra_files=extra)
        run = ("--policy", "noisy.pt", "--episodes", "12", "--repeats", "2", "--horizon", "60")
        for execute in (0, 3):
            self.succeed(*run, "--execute", f"{execute}", "--out", f"by_command_{execute}")
            policy = sim2sim.load_policy("noisy.pt", execute=execute)
            out = f"in_python_{execute}"
            sim2sim.compare(policy, episodes=12, repeats=2, horizon=60, threads=2, out=out)
            self.assertEqual(
                self.files(out)["episodes.csv"], self.files(f"by_command_{execute}")["episodes.csv"]
            )
        first, second = (self.files(f"in_python_{execute}")["episodes.csv"] for execute in (0, 3))
        self.assertNotEqual(first, second)

    def test_parameters_and_options_are_the_commands(self) -> None:
        arguments = (
            *("--policy", "expert", "--engine", "chipmunk", "--set", "substep=0.005"),
            *("--set-reference", "timestep=0.005", "--reanchor", "1,5", "--episodes", "3"),
            *("--no-floor", "--bound-angle", "0.3", "--loop", "action_delay=1", "--repeats", "3"),
        )
        self.succeed(*arguments, "--out", "by_command")
        sim2sim.compare(
            "expert",
            engine="chipmunk",
            engine_parameters={"substep": 0.005},
            reference_parameters={"timestep": 0.005},
            reanchor=[1, 5],
            episodes=np.int64(3),
            floor=False,
            bound_angle=np.float64(0.3),
            loop={"action_delay": 1},
            repeats=3,
            out=Path("in_python"),
        )
        self.assertEqual(self.files("in_python"), self.files("by_command"))

    def test_an_option_whose_value_may_be_left_out(self) -> None:
        run: Dict[str, Any] = {**SHORT, "episodes": 1}
        with_all = sim2sim.compare("expert", reanchor=True, **run).summary["probes"]
        self.assertEqual(with_all, [f"engine_reanchored_{k}" for k in (1, 5, 20)])
        self.assertEqual(sim2sim.compare("expert", reanchor=False, **run).summary["probes"], [])


class Results(ComparisonCase):
    def test_columns_are_those_of_the_file(self) -> None:
        results = sim2sim.compare(charge, out="out", **SHORT)
        rows = (self.folder / "out" / "episodes.csv").read_text().splitlines()
        self.assertEqual(list(results.episodes), rows[0].split(","))
        for name, column in results.episodes.items():
            index = rows[0].split(",").index(name)
            for value, row in zip(column, rows[1:]):
                cell = row.split(",")[index]
                if isinstance(value, np.floating):
                    self.assertEqual(repr(float(value)), repr(float(cell or "nan")), name)
                else:
                    self.assertEqual(str(value).lower() if name == "success" else str(value), cell)
        self.assertEqual(results.episodes["seed"].dtype, np.uint64)
        self.assertEqual(len(rows), 1 + 4 * 3)

    def test_a_loop_may_have_a_name(self) -> None:
        results = sim2sim.compare("expert", loop="tracker", **SHORT)
        changed = results.summary["simulators"]["engine"]["changed"]
        self.assertEqual(changed[:2], ["loop.preset", "loop.observation_delay"])
        self.assertEqual(set(results.episodes["ending"]) - {"moving", "success"}, {""})

    def test_the_reference_alone(self) -> None:
        out = self.folder / "alone"
        options: Dict[str, Any] = {"engine": "none", "episodes": 10, "repeats": 2}
        alone = sim2sim.compare("expert", out=out, **options)
        self.assertEqual(set(alone.episodes["mode"]), {"reference_closed"})
        self.assertIn("reference_success_variance_repeats", alone.summary)
        self.assertEqual(alone.summary["number_of_starts"], 5)
        self.assertEqual(sim2sim.load(out).text, "".join(alone.text.splitlines(True)[1:-2]))

    def test_repeats_are_a_column_of_whole_numbers(self) -> None:
        repeat = sim2sim.compare(charge, repeats=2, **SHORT).episodes["repeat"]
        self.assertEqual((repeat.dtype, repeat.tolist()), (np.int64, [0, 0, 0, 1, 1, 1] * 2))

    def test_page_says_what_its_command_does_not_know(self) -> None:
        sim2sim.compare(charge, out="out", **SHORT)
        subprocess.run([REPORT, "out"], check=True, timeout=120, stdout=subprocess.DEVNULL)
        page = (self.folder / "out" / "report.html").read_text()
        self.assertIn("The policy was a Python object: give it to sim2sim.compare()", page)

    def test_nothing_is_written_unless_asked_for(self) -> None:
        results = sim2sim.compare(charge, **SHORT)
        self.assertEqual(list(self.folder.iterdir()), [])
        self.assertIsNone(results.folder)
        self.assertNotIn("results:", results.text)
        for name in ("record", "traces", "overwrite"):
            self.refused(
                f"^{name}: must be left out without out", lambda: self.short(**{name: True})
            )

    def short(self, policy: object = charge, **options: Any) -> sim2sim.Comparison:
        return sim2sim.compare(policy, **{**SHORT, **options})

    def test_provenance_says_that_it_is_a_callable(self) -> None:
        provenance = self.short(history=2, policy=lambda o: charge(o[:, 1])).provenance
        self.assertRegex(provenance["policy"]["callable"], r"test_comparison\..*<lambda>$")
        self.assertEqual(provenance["policy"]["history"], 2)
        self.assertIsNone(provenance["policy"]["version"])
        results = self.short(Counting(), version="7")
        self.assertRegex(results.summary["policy"], r"^python:.*Counting$")
        self.assertEqual(results.provenance["policy"]["version"], "7")

    def test_given_starts_have_no_seeds(self) -> None:
        Path("starts.csv").write_text("pusher_x,pusher_y,tee_x,tee_y,tee_yaw\n-0.2,0,-0.1,0.1,1\n")
        results = sim2sim.compare(charge, starts="starts.csv", horizon=20)
        self.assertNotIn("seed", results.episodes)
        self.assertEqual(set(results.episodes["episode"]), {0})


class Callables(ComparisonCase):
    def test_history_and_chunks(self) -> None:
        seen: List[Rows] = []

        def policy(observations: Rows) -> Rows:
            seen.append(observations)
            return np.repeat(charge(observations[:, -1])[:, np.newaxis], 5, axis=1)

        run: Dict[str, Any] = {**SHORT, "episodes": 1, "horizon": 7}
        sim2sim.compare(policy, history=3, execute=2, **run)
        self.assertEqual([call.shape for call in seen[:2]], [(8, 3, 10)] * 2)
        self.assertEqual(seen[2].shape, (3, 3, 10))
        del seen[:TRIALS]
        self.assertEqual([call.shape for call in seen], [(2, 3, 10)] * 4)  # steps 0, 2, 4, 6
        for row in (0, 1):
            np.testing.assert_array_equal(seen[0][row], np.repeat(seen[0][row, :1], 3, axis=0))
            np.testing.assert_array_equal(seen[1][row, 0], seen[0][row, 2])
            np.testing.assert_array_equal(seen[2][row, 0], seen[1][row, 2])
            self.assertFalse((seen[1][row, 1] == seen[1][row, 0]).all())  # it sees every step
        seen.clear()
        sim2sim.compare(policy, history=1, **run)
        self.assertEqual(
            [call.shape for call in seen[TRIALS:]], [(2, 1, 10)] * 2
        )  # all five are taken

    def test_a_history_and_a_chunk_of_one_are_the_plain_policy(self) -> None:
        plain = sim2sim.compare(charge, **SHORT)
        one = sim2sim.compare(lambda o: charge(o[:, 0])[:, np.newaxis], history=1, **SHORT)
        for name, column in plain.episodes.items():
            np.testing.assert_array_equal(one.episodes[name], column, name)

    def test_memory_belongs_to_the_rollout(self) -> None:
        seeds: Dict[bool, List[int]] = {}
        for independent in (False, True):
            policy = Counting()
            run: Dict[str, Any] = {**SHORT, "independent_noise": independent}
            first = sim2sim.compare(policy, **run)
            del policy.seeds[:TRIED]
            self.assertEqual(len(policy.seeds), 8)  # four episodes, two sides
            self.assertEqual(len(set(policy.seeds)), 8 if independent else 4)
            for threads in (2, 3):
                other = sim2sim.compare(Counting(), threads=threads, **run)
                np.testing.assert_array_equal(
                    other.episodes["final_position_error_m"],
                    first.episodes["final_position_error_m"],
                )
            seeds[independent] = policy.seeds
        self.assertNotEqual(sorted(seeds[False]), sorted(seeds[True]))

    def test_memories_are_let_go(self) -> None:
        alive: Set[int] = set()

        class Memory:
            def __init__(self) -> None:
                alive.add(id(self))

            def __del__(self) -> None:
                alive.remove(id(self))

        class Policy:
            def begin(self, seed: int) -> Memory:
                return Memory()

            def act(self, observations: Rows, memories: List[Memory]) -> Rows:
                self.most = max(getattr(self, "most", 0), len(alive))
                return charge(observations)

        policy = Policy()
        run: Dict[str, Any] = {**SHORT, "episodes": 40, "horizon": 5}
        sim2sim.compare(policy, **run)
        self.assertEqual(len(alive), 0)
        self.assertLess(policy.most, 40)

    def test_calls_come_from_the_callers_thread(self) -> None:
        threads: Set[int] = set()

        def policy(observations: Rows) -> Rows:
            threads.add(threading.get_ident())
            return charge(observations)

        sim2sim.compare(policy, threads=3, **SHORT)
        self.assertEqual(threads, {threading.get_ident()})

    def test_calls_are_the_same_in_every_run(self) -> None:
        """With one thread, which is the default."""

        def calls() -> List[bytes]:
            seen: List[bytes] = []

            def policy(observations: Rows) -> Rows:
                seen.append(observations.tobytes())
                return charge(observations)

            run: Dict[str, Any] = {**SHORT, "episodes": 12}
            sim2sim.compare(policy, **run)
            return seen

        first = calls()
        self.assertGreater(max(map(len, first[TRIALS:])), 8 * 10 * 4)  # many rows at once
        self.assertEqual(calls(), first)

    def test_a_policy_of_the_suite_beside_other_loops(self) -> None:
        """Observations are those of the loop, whatever the policy is."""
        loop: Dict[str, Any] = {"loop": {"observation_delay": 2}, "noise_seed": 4}
        shipped = sim2sim.load_policy("expert")
        by_name = sim2sim.compare("expert", **SHORT, **loop)
        np.testing.assert_array_equal(
            sim2sim.compare(shipped, **SHORT, **loop).episodes["final_position_error_m"],
            by_name.episodes["final_position_error_m"],
        )


class Failures(ComparisonCase):
    def failing(self, policy: object, **options: Any) -> Callable[[], object]:
        return lambda: sim2sim.compare(policy, **{**SHORT, **options})

    def test_an_exception_of_the_callable_is_raised_as_itself(self) -> None:
        error = KeyError("my own")

        def policy(observations: Rows) -> Rows:
            raise error

        for threads in (1, 2):
            with self.assertRaises(KeyError) as caught:
                sim2sim.compare(policy, threads=threads, out=f"out-{threads}", **SHORT)
            self.assertIs(caught.exception, error)
            status = self.load(f"out-{threads}", "status.json")
            self.assertEqual(status["exit_code"], 4)
            self.assertRegex(status["reason"], r"policy .*policy: raised KeyError: 'my own'$")
            self.assertNotIn("metrics.json", self.files(f"out-{threads}"))

        class Begins:
            def begin(self, seed: int) -> object:
                raise error

            def act(self, observations: Rows, memories: List[object]) -> Rows:
                return charge(observations)

        with self.assertRaises(KeyError):
            sim2sim.compare(Begins(), **SHORT)

    def test_answers_of_the_wrong_kind(self) -> None:
        def of(answer: Callable[[int], object]) -> Callable[[], object]:
            return self.failing(lambda rows: answer(len(rows)), episodes=1)

        must = (
            r"must be float32 \(or float64\) of shape \(8, 2\), or \(8, K, 2\) for K control steps$"
        )
        for answer, line in (
            (lambda n: np.zeros((n, 3), np.float32), r"float32 of shape \(8, 3\)"),
            (lambda n: np.zeros((n + 1, 2), np.float32), r"float32 of shape \(9, 2\)"),
            (lambda n: np.zeros((n, 0, 2), np.float32), r"float32 of shape \(8, 0, 2\)"),
            (lambda n: np.zeros((n, 2), np.int64), r"int64 of shape \(8, 2\)"),
            (lambda n: np.zeros((n, 2), np.float16), r"float16 of shape \(8, 2\)"),
            (lambda n: None, r"object of shape \(\)"),
        ):
            with self.subTest(line):
                self.refused(rf"^policy .*: answered {line}: {must}", of(answer), 3)
        ragged = self.failing(lambda rows: [[0.0, 0.0], [0.0]], episodes=1)
        self.refused(
            r"^policy .*: answered a <class 'list'> that is no array: setting an", ragged, 3
        )
        chunk = self.failing(lambda rows: np.zeros((len(rows), 4, 2)), execute=5)
        self.refused("^execute 5: must be from 1 to 4, the actions of an answer", chunk)

    def test_numbers_that_are_not_finite(self) -> None:
        def policy(observations: Rows) -> Rows:
            actions = np.zeros((len(observations), 8, 2), np.float32)
            actions[:, 6, 1] = np.nan
            return actions

        line = (
            r"^episode 0 \(spawn seed 10000\), reference_closed, step 6: the policy's action "
            r"\(0.000000, nan\) must be finite$"
        )
        self.refused(line, self.failing(policy), 3)

    def test_words_are_the_commands(self) -> None:
        cases: List[Tuple[List[str], Dict[str, Any]]] = [
            (["--episodes", "0"], {"episodes": 0}),
            (["--episodes", "ten"], {"episodes": "ten"}),
            (["--episodes=1.5"], {"episodes": 1.5}),
            (["--episods", "3"], {"episods": 3}),
            (["--seed=-1"], {"seed": -1}),
            (["--bound-angle=nan"], {"bound_angle": float("nan")}),
            (["--engine", "two_mas"], {"engine": "two_mas"}),
            (["--set", "block_damp=110"], {"engine_parameters": {"block_damp": 110}}),
            (["--set", "damp=1"], {"engine_parameters": {"damp": 1}}),
            (["--loop", "delay=1"], {"loop": {"delay": 1}}),
            (["--threads", "0"], {"threads": 0}),
            (["--reanchor", "0"], {"reanchor": [0]}),
            (["--starts", "none.csv"], {"starts": "none.csv"}),
            (["--policy", "none.pt"], {"policy": "none.pt"}),
            (["--execute", "2"], {"execute": 2}),
            (["--out", ""], {"out": ""}),
        ]
        Path("of_command").mkdir()
        for arguments, options in cases:
            with self.subTest(str(arguments)):
                policy = [] if "policy" in options else ["--policy", "expert"]
                process = self.command(*policy, *arguments, folder="of_command")
                self.assertEqual(process.returncode, 2)
                with self.assertRaises(sim2sim.InvalidInput) as caught:
                    sim2sim.compare(options.pop("policy", "expert"), **options)
                self.assertEqual(f"compare: {caught.exception}\n", process.stderr)
        self.assertEqual([file.name for file in self.folder.iterdir()], ["of_command"])

    def test_what_a_callable_cannot_have(self) -> None:
        cases: List[Tuple[str, Dict[str, Any]]] = [
            ("^smoke: must be left out", {"smoke": True}),
            ("^reference_cache c: must be left out without a version", {"reference_cache": "c"}),
            ("^history 0: must be from 1 to 1000$", {"history": 0}),
            (r"^episodes \{'a': 1\}: must not be a dict$", {"episodes": {"a": 1}}),
            (r"^'a\\x00b': must have no NUL character$", {"out": "a\0b"}),
            (r"^'starts\\x00': must have no NUL character$", {"write_starts": "starts\0"}),
            (r"^'\\ud800': must be text that UTF-8 can hold$", {"engine": "\ud800"}),
            (r"^help: there is no such option; ", {"help": True}),
            ("^version 3: must be text without NUL characters$", {"version": 3}),
            ("^engine_parameters 3: must be a dict$", {"engine_parameters": 3}),
        ]
        for line, options in cases:
            self.refused(line, partial(sim2sim.compare, charge, **options))
        self.refused("^history 2: must be left out", lambda: sim2sim.compare("expert", history=2))
        self.refused("^policy 3: must be a name, a file", lambda: sim2sim.compare(3))
        expert, rows = sim2sim.load_policy("expert"), np.zeros((1, 10), np.float32)
        memories: List[Any] = [None]
        words: Any = "up"
        self.refused("^memories: the one of row 0 must be", lambda: expert.act(rows, memories))
        self.refused("^memories 'up': must be a list", lambda: expert.act(rows, words))
        self.refused("^observations <U2 of shape", lambda: expert.act(words, []))
        ragged: Any = [[0.0], []]
        self.refused("^observations .*inhomogeneous", lambda: expert.act(ragged, []))
        self.refused("^seed 'up': must be an integer", lambda: expert.begin(words))
        number: Any = 3
        self.refused("^policy 3: must be a name or a path$", lambda: sim2sim.load_policy(number))
        self.refused(
            "^execute 'up': must be an integer", lambda: sim2sim.load_policy("bc", execute=words)
        )
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_a_callable_that_changes_folders(self) -> None:
        (self.folder / "elsewhere").mkdir()

        def policy(observations: Rows) -> Rows:
            os.chdir(self.folder / "elsewhere")
            return charge(observations)

        found = sim2sim.compare(policy, out="out", write_starts="s.csv", **SHORT)
        self.assertEqual(found.folder, self.folder / "out")
        self.assertEqual({"elsewhere", "out", "s.csv"}, {f.name for f in self.folder.iterdir()})
        self.assertEqual(list((self.folder / "elsewhere").iterdir()), [])

    def test_a_run_beside_itself(self) -> None:
        def policy(observations: Rows) -> Rows:
            sim2sim.compare("expert", **SHORT)
            return charge(observations)

        self.refused("^compare: another command runs already in this process", self.failing(policy))
        sim2sim.compare(charge, **SHORT)

    def test_warnings_are_pythons(self) -> None:
        def run() -> sim2sim.Comparison:
            return sim2sim.compare("none.pt", allow_untrained=True, **SHORT)

        with warnings.catch_warnings(record=True) as caught, contextlib.redirect_stderr(
            io.StringIO()
        ):
            warnings.simplefilter("always")
            self.assertEqual(run().summary["policy"], "fresh-untrained")
        self.assertRegex(str(caught[0].message), "none.pt: there is no such file. Running an UNTR")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with self.assertRaises(RuntimeWarning):
                run()


class Queue:
    """Answers from a queue of eight actions, filled when it is empty, as a robot's policy may."""

    def __init__(self) -> None:
        self.queue: List[Rows] = []

    def __call__(self, observations: Rows) -> Rows:
        if not self.queue:
            self.queue = [charge(observations) * (1.0 - 0.1 * step) for step in range(8)]
        return self.queue.pop(0)


class Stateful(Queue):
    """Likewise, behind the interface of a policy whose memories the suite keeps."""

    def begin(self, seed: int) -> None:
        return None

    def act(self, observations: Rows, memories: List[None]) -> Rows:
        return self(observations)


class MemoriesOfTheirOwn(ComparisonCase):
    def found_out(self, policy: object, when: str, **options: Any) -> None:
        run: Dict[str, Any] = {**SHORT, **options}
        rule = r": it has .* or mixes rows; give .*begin\(seed\) and act\(.*\), or .* chunks"
        line = f"^policy .*: answers the same observation with another action {when}{rule}"
        self.refused(line, lambda: sim2sim.compare(policy, **run), 3)

    def test_they_are_found_out_before_the_run(self) -> None:
        again = "when the rows come again in another order"
        random = np.random.default_rng(0)
        self.found_out(Queue(), again)
        self.found_out(Stateful(), again)
        self.found_out(lambda rows: random.uniform(-1.0, 1.0, (len(rows), 2)), again)
        self.found_out(lambda rows: charge(rows[::-1].copy()), "beside other rows")
        self.found_out(lambda rows: charge(rows - rows.mean(0)), "beside other rows")
        looking_back = Queue()
        self.found_out(lambda rows: looking_back(rows[:, -1]), again, history=3)
        self.found_out(Queue(), again, out="out")
        self.assertFalse((self.folder / "out").exists())

    def test_what_rounding_makes_is_none(self) -> None:
        sim2sim.compare(lambda rows: charge(rows) + 1e-4 / len(rows), **SHORT)


class Modules(ComparisonCase):
    """PyTorch's modules as policies."""

    def network(self) -> torch.nn.Module:
        torch.manual_seed(0)
        return torch.nn.Sequential(
            torch.nn.Linear(10, 16), torch.nn.Dropout(0.5), torch.nn.Tanh(), torch.nn.Linear(16, 2)
        )

    def test_eager_and_scripted_are_their_own_function(self) -> None:
        network = self.network().train()
        network[3].eval()  # type: ignore[index]
        scripted = torch.jit.script(self.network())
        eager = sim2sim.compare(network, **SHORT)
        self.assertTrue(network.training)
        self.assertEqual([part.training for part in network], [True] * 3 + [False])  # type: ignore
        compared = sim2sim.compare(scripted, **SHORT)
        self.assertTrue(scripted.training)
        network.eval()

        def by_hand(observations: Rows) -> Rows:
            with torch.no_grad():
                answer: Rows = network(torch.from_numpy(observations)).numpy()
            return answer

        wanted = sim2sim.compare(by_hand, **SHORT).episodes
        for found in (eager, compared):
            for name, column in wanted.items():
                np.testing.assert_array_equal(found.episodes[name], column, name)
        self.assertEqual(eager.summary["policy"], "python:torch.nn.modules.container.Sequential")
        self.assertEqual(compared.summary["policy"], "python:torch.jit.Sequential")

    def test_precision_history_and_chunks(self) -> None:
        class Looking(torch.nn.Module):
            def __init__(self) -> None:
                super().__init__()
                self.net = torch.nn.Linear(20, 8)

            def forward(self, observations: torch.Tensor) -> torch.Tensor:
                return self.net(observations.flatten(1)).view(-1, 4, 2)

        for precision in (torch.float32, torch.float64, torch.bfloat16):
            module = Looking().to(precision)
            sim2sim.compare(module, history=2, execute=3, **SHORT)

    def test_a_function_may_answer_with_a_tensor(self) -> None:
        network = self.network().eval()
        sim2sim.compare(lambda rows: network(torch.from_numpy(rows)), **SHORT)

    def test_a_module_with_a_memory(self) -> None:
        class Remembering(torch.nn.Module):
            def begin(self, seed: int) -> List[float]:
                return [0.0]

            def act(self, observations: Rows, memories: List[List[float]]) -> torch.Tensor:
                assert not self.training
                for memory in memories:
                    memory[0] += 0.01
                return torch.tensor([[memory[0], 0.0] for memory in memories])

        sim2sim.compare(Remembering(), **SHORT)


class Interruptions(ComparisonCase):
    def test_ctrl_c_in_a_callable(self) -> None:
        calls = 0

        def policy(observations: Rows) -> Rows:
            nonlocal calls
            calls += 1
            if calls == 50:
                signal.raise_signal(signal.SIGINT)
            return charge(observations)

        run: Dict[str, Any] = {**SHORT, "episodes": 200}
        with self.assertRaises(KeyboardInterrupt):
            sim2sim.compare(policy, out="out", **run)
        self.assertEqual(calls, 50)
        self.assertEqual(set(self.files("out")), {"episodes.csv", "provenance.json", "status.json"})
        status = self.load("out", "status.json")
        self.assertEqual((status["exit_code"], status["episodes"]), (4, 200))
        self.assertGreater(status["episodes_finished"], 0)
        self.refused("^out", lambda: sim2sim.compare(charge, out="out", **run))  # begins again
        sim2sim.compare(charge, out="out", overwrite=True, **SHORT)
        self.assertIn("metrics.json", self.files("out"))

    def interrupted(self, program: str) -> "subprocess.CompletedProcess[str]":
        """Output of a Python program that gets SIGINT once it prints a line."""
        with subprocess.Popen(
            [sys.executable, "-c", program],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as process:
            assert process.stdout
            self.assertEqual(process.stdout.readline(), "runs\n")
            process.send_signal(signal.SIGINT)
            said, complained = process.communicate(timeout=DEADLINE)
        return subprocess.CompletedProcess([], process.returncode, said, complained)

    def test_ctrl_c_reaches_a_callable_that_does_not_return(self) -> None:
        process = self.interrupted(
            "import signal, sim2sim\n"
            "def policy(rows):\n"
            "    print('runs', flush=True)\n"
            "    while True: signal.pause()\n"
            "sim2sim.compare(policy, out='out')\n"
        )
        self.assertTrue(process.stderr.endswith("\nKeyboardInterrupt\n"), process.stderr)
        self.assertEqual(self.load("out", "status.json")["reason"], "interrupted")

    def test_ctrl_c_while_a_policy_of_the_suite_runs(self) -> None:
        process = self.interrupted(
            "import sim2sim, pathlib, threading, time\n"
            "def watch():\n"
            "    journal = pathlib.Path('out/episodes.journal')\n"
            "    while not journal.exists() or journal.read_text().count('\\n') < 3: pass\n"
            "    print('runs', flush=True)\n"
            "threading.Thread(target=watch).start()\n"
            "try:\n"
            "    sim2sim.compare('expert', episodes=100000, out='out')\n"
            "except KeyboardInterrupt:\n"
            "    print('interrupted')\n"
        )
        self.assertEqual((process.stdout, process.stderr), ("interrupted\n", ""))
        status = self.load("out", "status.json")
        self.assertRegex(
            status["reason"], r"^interrupted after \d+ of 100000 episodes; to continue"
        )
        self.assertEqual([name for name in self.files("out") if name.endswith(".part")], [])

    def test_an_interpreter_that_ends_ends_the_run_of_a_daemon_thread(self) -> None:
        program = (
            "import numpy, sim2sim, threading\n"
            "runs = threading.Event()\n"
            "def policy(rows):\n"
            "    runs.set()\n"
            "    return numpy.zeros((len(rows), 2))\n"
            "def run():\n"
            "    sim2sim.compare(policy, episodes=100000, out='out')\n"
            "threading.Thread(target=run, daemon=True).start()\n"
            "runs.wait()\n"
        )
        process = subprocess.run(
            [sys.executable, "-c", program], cwd=self.folder, capture_output=True, timeout=DEADLINE
        )
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertEqual(self.load("out", "status.json")["exit_code"], 4)

    def test_a_version_lets_a_run_go_on(self) -> None:
        calls = 0

        def policy(observations: Rows) -> Rows:
            nonlocal calls
            calls += 1
            if calls == 120:
                raise RuntimeError("stop")
            return charge(observations)

        run: Dict[str, Any] = {**SHORT, "episodes": 60}
        sim2sim.compare(charge, out="whole", **run)
        with self.assertRaises(RuntimeError):
            sim2sim.compare(policy, version="1", out="out", **run)
        finished = self.load("out", "status.json")["episodes_finished"]
        self.assertGreater(finished, 0)
        self.refused(
            rf"^journal {self.folder}/out/episodes.journal: is of another run \(.*version",
            lambda: sim2sim.compare(policy, version="2", out="out", **run),
        )
        calls_before = calls
        sim2sim.compare(policy, version="1", out="out", **run)
        self.assertEqual(self.files("out")["episodes.csv"], self.files("whole")["episodes.csv"])
        self.assertLess(calls - calls_before, calls_of(run))


def calls_of(run: Dict[str, Any]) -> int:
    """How often a whole run asks its policy."""
    calls = 0

    def policy(observations: Rows) -> Rows:
        nonlocal calls
        calls += 1
        return charge(observations)

    sim2sim.compare(policy, **run)
    return calls


class Examples(ComparisonCase):
    EXAMPLES = Path(__file__).resolve().parents[1] / "examples"

    def run_example(self, name: str) -> str:
        path = self.EXAMPLES / name
        self.assertLessEqual(len(path.read_text().splitlines()), 20)
        process = subprocess.run([sys.executable, str(path)], capture_output=True, text=True)
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        return process.stdout

    def test_they_run(self) -> None:
        said = {
            "own_counts.py": "trials to find 0.1: ",
            "straight_at_the_tee.py": "success, closed loop",
            "torch_module.py": "success, closed loop",
            "two_runs.py": "success, other - pilot",
        }
        self.assertEqual(set(said), {path.name for path in self.EXAMPLES.glob("*.py")})
        for name, line in said.items():
            with self.subTest(name):
                self.assertIn(line, self.run_example(name))

    def test_the_tutorial_has_those_of_policies(self) -> None:
        tutorial = (self.EXAMPLES.parents[2] / "docs" / "tutorial.md").read_text()
        for name in ("straight_at_the_tee.py", "torch_module.py"):
            head, body = (self.EXAMPLES / name).read_text().split('"""\n', 1)
            self.assertIn(f"```python\n# {name}\n{body.strip()}\n```", tutorial)


if __name__ == "__main__":
    unittest.main()
