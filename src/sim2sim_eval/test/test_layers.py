#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The libraries that know no ROS need none of its libraries, nor those of a simulator. Headers that
take long to compile are included only where they are needed. Files that come from outside are read
by one owner in C++ and one in Python.
"""

import re
import unittest
from pathlib import Path
from typing import Dict, Set

from command_case import CommandCase, executable

LIBRARIES = Path(executable("sim2sim_eval", "compare")).parents[1]
SOURCES = Path(__file__).resolve().parents[2]
# Headers of others that take a second or more to compile in each unit, with those of ours that may
# include them. For most purposes nlohmann/json_fwd.hpp or a declaration of CLI::App is enough.
HEAVY: Dict[str, Set[str]] = {
    "CLI/": set(),
    "boost/math/": {"sim2sim_statistics/src/pair_scores.hpp"},
    "boost/process/": set(),
    "nlohmann/json.hpp": {
        "pusht_policy/include/pusht_policy/policy_choice.hpp",
        "pusht_policy/include/pusht_policy/policy_description.hpp",
        "pusht_task/include/pusht_task/simulator_kind.hpp",
        "pusht_testing/include/pusht_testing/golden.hpp",
        "sim2sim_eval/include/sim2sim_eval/batch/comparison.hpp",
        "sim2sim_eval/include/sim2sim_eval/batch/loaded_run.hpp",
        "sim2sim_eval/src/bag/recorded_run.hpp",
        "sim2sim_eval/src/batch/demonstration_simulators.hpp",
        "sim2sim_eval/src/batch/sweep_description.hpp",
        "sim2sim_eval/src/batch/sweep_folder.hpp",
        "sim2sim_protocol/include/sim2sim_protocol/reference_cache.hpp",
        "sim2sim_protocol/include/sim2sim_protocol/results/agreement.hpp",
        "sim2sim_protocol/include/sim2sim_protocol/results/json.hpp",
        "sim2sim_protocol/include/sim2sim_protocol/results/run.hpp",
        "sim2sim_protocol/include/sim2sim_protocol/results/run_configuration.hpp",
        "sim2sim_protocol/include/sim2sim_protocol/results/run_folder.hpp",
        "sim2sim_protocol/include/sim2sim_protocol/results/run_results.hpp",
        "sim2sim_serving/include/sim2sim_serving/policy_session.hpp",
    },
    "regex": set(),
    "ros/ros.h": set(),
    "torch/": {"pusht_policy/src/graph_sizes.hpp", "pusht_policy/src/torch_reader.hpp"},
    "yaml-cpp/": {
        "sim2sim_eval/src/batch/plan_loops.hpp",
        "sim2sim_eval/src/batch/plan_policies.hpp",
        "sim2sim_eval/src/batch/plan_values.hpp",
    },
}

# What reads a file, or a text in JSON or YAML, and the sources that may: the owners, and what reads
# something that is no input (the package's own data, /proc, what it has just written).
READING_CPP = re.compile(
    r"\bw?i?fstream\b|\brdbuf\b|\bf(?:re)?open\(|[^:\w]::open\("
    r"|[Jj]son::parse\(|\bLoad(?:All|File)?\("
)
READERS_CPP = {
    "pusht_policy/src/policy_description.cpp",  # refuses a key that is there twice, and is small
    "pusht_testing/src/golden.cpp",
    "pusht_policy/src/rehearsal.cpp",  # /dev/null
    "pusht_task/include/pusht_task/standard_streams.hpp",  # /dev/null
    "pusht_task/src/files.cpp",
    "pusht_task/src/json_text.cpp",
    "sim2sim_serving/src/simulator_kinds.cpp",  # what a package describes, in XML
    "sim2sim_eval/src/batch/plan_values.hpp",  # YAML
    "sim2sim_protocol/src/results/journal.cpp",  # to write
    "sim2sim_protocol/src/results/output_folder.cpp",  # a folder, to lock it
}
READING_PYTHON = re.compile(
    r"(?<!os\.)(?<!fd)\bopen\(|\bread_bytes\(|\.read_text\(|\bfromfile\("
    r"|\bjson\.load\(|\b(?:np|numpy)\.load|\byaml\.(?:safe_)?load|\btorch\.(?:jit\.)?load\("
)
READERS_PYTHON = {
    "pusht_policy/src/pusht_policy/formats.py",
    "pusht_policy/src/pusht_policy/onnx_export.py",  # what the owner has read
    "pusht_policy/src/pusht_policy/software.py",
    "pusht_policy/src/pusht_policy/trainer.py",  # what the owner has read
    "pusht_policy/src/pusht_policy/training.py",  # a lock
    "pusht_task/src/pusht_task/command.py",  # the mark of a file that is to be replaced
    "pusht_task/src/pusht_task/files.py",
    "pusht_task/src/pusht_task/machine.py",
    "pusht_task/src/pusht_task/palette.py",
    "sim2sim_eval/scripts/rviz_window",
    "sim2sim_eval/scripts/sweep_dask",  # what its command has just written
    "sim2sim_protocol/src/sim2sim_protocol/result_files.py",
    "sim2sim_report/src/sim2sim_report/page.py",
    "sim2sim_report/src/sim2sim_report/results.py",  # an array, of bytes that the owner has read
    "sim2sim_report/src/sim2sim_report/words.py",
    "sim2sim_study/src/sim2sim_study/conduct.py",  # what the owner has read, and a policy
    "sim2sim_study/src/sim2sim_study/plan.py",  # YAML
}


def includes(file: Path) -> Set[str]:
    return set(re.findall(r'^ *#include [<"](.+)[>"]', file.read_text(), re.M))


class Headers(unittest.TestCase):
    headers = [
        file
        for folder in ("include", "src")
        for file in SOURCES.glob(f"*/{folder}/**/*.hpp")
        if "test" not in file.parts
    ]

    def test_heavy_ones_are_included_where_they_are_needed_alone(self) -> None:
        self.assertGreater(len(self.headers), 200)
        for heavy, allowed in HEAVY.items():
            found = {
                str(file.relative_to(SOURCES))
                for file in self.headers
                if any(name.startswith(heavy) for name in includes(file))
            }
            self.assertEqual(found, allowed, heavy)

    def test_a_main_needs_few_headers(self) -> None:
        """Or each command and node takes ten seconds to compile."""
        ours = {re.sub(".*/(include|src)/", "", str(file)): file for file in self.headers}
        for main in ("sim2sim_eval/batch/command_line", "live/evaluate", "live/serve_playback"):
            with self.subTest(main):
                seen: Set[str] = set()
                self.assertIn(f"{main}.hpp", ours)
                left = {f"{main}.hpp"}
                while left:
                    name = left.pop()
                    seen.add(name)
                    left |= (includes(ours[name]) if name in ours else set()) - seen
                heavy = {name for name in seen for begin in HEAVY if name.startswith(begin)}
                self.assertEqual(
                    {*heavy, *(name for name in seen if name.startswith("ros/"))}, set()
                )


class Reading(unittest.TestCase):
    def assert_read_by(self, readers: Set[str], reading: "re.Pattern[str]", *patterns: str) -> None:
        sources = {file for pattern in patterns for file in SOURCES.glob(pattern) if file.is_file()}
        self.assertGreater(len(sources), 30)
        found = {
            str(file.relative_to(SOURCES))
            for file in sources
            if "pusht_testing" not in file.parts or str(file.relative_to(SOURCES)) in readers
            if reading.search(file.read_text())
        }
        self.assertEqual(found, readers)

    def test_each_way_to_read_is_known(self) -> None:
        for text in (
            *("std::ifstream file(path);", "std::fstream file(path);", "bytes << file.rdbuf();"),
            *("fopen(name)", "nlohmann::json::parse(text)", "nlohmann::ordered_json::parse(text)"),
            *("YAML::LoadFile(path)", "const int file = ::open(path)"),
        ):
            self.assertRegex(text, READING_CPP)
        for text in (
            *("open(path)", "path.open()", "path.read_text()", 'path.read_text(encoding="utf-8")'),
            *("path.read_bytes()", "json.load(file)", "np.load(path)", "numpy.fromfile(path)"),
            *("yaml.safe_load(text)", "torch.load(path)", "torch.jit.load(path)"),
        ):
            self.assertRegex(text, READING_PYTHON)
        self.assertNotRegex("os.open(os.devnull, os.O_WRONLY)", READING_PYTHON)

    def test_cpp_reads_files_in_one_place(self) -> None:
        folders = ("include", "src", "nodes", "apps")
        ends = ("cpp", "hpp")
        patterns = [f"*/{folder}/**/*.{end}" for folder in folders for end in ends]
        self.assert_read_by(READERS_CPP, READING_CPP, *patterns)

    def test_python_reads_files_in_one_place(self) -> None:
        patterns = ("*/src/**/*.py", "*/scripts/*")
        self.assert_read_by(READERS_PYTHON, READING_PYTHON, *patterns)


class Layers(CommandCase):
    def needed(self, library: str) -> Set[str]:
        """The libraries that come with one, also through others."""
        process = self.run_command("ldd", str(LIBRARIES / library))
        self.assertEqual(process.returncode, 0, process.stderr)
        return {Path(line.split()[0]).name for line in process.stdout.splitlines()}

    def foreign(self, layer: str) -> Set[str]:
        """What a library needs besides ours and what `pusht_task`, which is free of ROS, needs."""
        needed = self.needed(f"libsim2sim_{layer}.so")
        own = {name for name in needed if name.startswith("libsim2sim_")}
        return needed - own - {"libpusht_task.so"} - self.needed("libpusht_task.so")

    def test_statistics_protocol_and_results_need_no_ros(self) -> None:
        for layer in ("statistics", "audit", "protocol", "results", "analyses"):
            self.assertEqual(self.foreign(layer), set(), layer)
        self.assertIn("libpusht_task.so", self.needed("libsim2sim_protocol.so"))

    def test_statistics_need_nothing_of_the_suite(self) -> None:
        ours = {name for name in self.needed("libsim2sim_statistics.so") if "pusht" in name}
        self.assertEqual(ours, set())

    def test_a_comparison_needs_neither_audits_nor_analyses(self) -> None:
        """Nor ONNX: `script/compare` builds none of them."""
        foreign = {"libsim2sim_analyses.so", "libsim2sim_audit.so", "libpusht_onnx_policy.so"}
        for program in ("sim2sim_eval/evaluator_node", "sim2sim_eval/simulator_node"):
            self.assertEqual(foreign & self.needed(program), set(), program)
        self.assertTrue(foreign & self.needed("sim2sim_eval/compare"))

    def test_those_that_need_it_show_it(self) -> None:
        """Or the other tests could not fail."""
        bag = self.foreign("bag")
        self.assertTrue(any(name.startswith("librosbag_storage.so") for name in bag), bag)
        self.assertTrue(self.engines("libpusht_mujoco.so"))

    def engines(self, program: str) -> Set[str]:
        """What a library or program needs of simulators."""
        words = ("mujoco", "chipmunk", "box2d", "Bullet", "ccd", "pusht_engine")
        return {name for name in self.needed(program) if any(word in name for word in words)}

    def test_programs_know_no_simulator(self) -> None:
        for program in ("compare", "evaluator_node", "simulator_node", "sweep"):
            self.assertEqual(self.engines(f"sim2sim_eval/{program}"), set(), program)

    def test_python_knows_neither_simulators_nor_libtorch(self) -> None:
        module = "python3/dist-packages/sim2sim/_sim2sim.so"
        self.assertEqual(self.engines(module), set())
        needed = self.needed(module)
        self.assertIn("libsim2sim_batch.so", needed)
        self.assertEqual({name for name in needed if "torch" in name or "live" in name}, set())
