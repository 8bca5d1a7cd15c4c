#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The scripts that check the suite: what they count, and which files they look at."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
CASE = '<testcase classname="C" name="n" file="/src/pusht_toy/test/toy_test.cpp"/>'


class ScriptCase(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, name: str, text: str) -> Path:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    def run_in_folder(self, *command: str) -> "subprocess.CompletedProcess[str]":
        return subprocess.run(
            command,
            cwd=self.folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )


class Count(ScriptCase):
    """A source tree of one package, and a build folder where all its tests passed."""

    RESULTS = {
        "gtest-toy_test.xml": CASE,
        "pytest-test.test_toy.py.xml": '<testcase classname="C" name="n"/>',
        "rostest-test_toy.xml": '<testcase classname="C" name="n"/>',
        "rosunit-live_toy.xml": '<testcase classname="C" name="n"/>',
    }

    def setUp(self) -> None:
        super().setUp()
        for name, text in (
            ("toy_test.cpp", "TEST(Toy, Moves) {}\n"),
            ("panel_test.cpp", "TEST_F(Panel, Opens) {}\n"),
            ("test_toy.py", 'PANEL = "panel_test"\n\n\nclass C:\n    def test_it(self): ...\n'),
            ("toy.test", '<launch><test test-name="live_toy" type="live_toy.py"/></launch>\n'),
            ("live_toy.py", "class C:\n    def test_it(self): ...\n"),
            ("support.py", "def help(): ...\n"),
        ):
            self.write(f"src/pusht_toy/test/{name}", text)
        for name, cases in self.RESULTS.items():
            self.result(name, cases)
        # What CMake registers, as catkin_run_tests_target writes it.
        lines = []
        for test, results in (
            ("gtest_toy_test", "gtest-toy_test.xml"),
            ("pytest_test.test_toy.py", "pytest-test.test_toy.py.xml"),
            ("rostest_test_toy.test", "rostest-test_toy.xml"),
        ):
            path = self.folder / "build" / "test_results" / "pusht_toy" / results
            lines.append(f'add_test(_ctest_pusht_toy_{test} "env" "run_tests.py" "{path}" "true")')
        self.write("build/CTestTestfile.cmake", "\n".join(lines) + "\n")

    def result(self, name: str, cases: str, folder: str = "build") -> Path:
        text = f"<testsuites><testsuite>{cases}</testsuite></testsuites>"
        return self.write(f"{folder}/test_results/pusht_toy/{name}", text)

    def count(self, *arguments: str, lint: str = "passed") -> "subprocess.CompletedProcess[str]":
        return self.run_in_folder(
            sys.executable, str(ROOT / "script" / "count_tests.py"), "--lint", lint,
            *(arguments or ("--all", "src", "--ran", "build", "run_tests")),
        )  # fmt: skip

    def assert_output(
        self, process: "subprocess.CompletedProcess[str]", code: int, *lines: str
    ) -> None:
        self.assertEqual(process.stdout.splitlines(), list(lines))
        self.assertEqual(process.returncode, code)

    def test_all_passed(self) -> None:
        self.assert_output(self.count(), 0, "5 passed, 0 failed")

    def test_failures(self) -> None:
        for kind in ("failure", "error"):
            case = f'<testcase classname="C" name="n"><{kind} message="no"/></testcase>'
            self.result("rosunit-live_toy.xml", case)
            self.assert_output(self.count(), 1, "FAILED: C.n", "4 passed, 1 failed")
        self.result("rosunit-live_toy.xml", "<testcase")
        *_, last = self.count().stdout.splitlines()
        self.assertEqual(last, "4 passed, 3 failed")  # damaged, and of two files no result

    def test_skipped_ones_are_shown_and_counted(self) -> None:
        cases = (
            '<testcase classname="C" name="a"><skipped message="no FMA"/></testcase>'
            '<testcase classname="C" name="b" status="notrun"/>'
        )
        self.result("rosunit-live_toy.xml", cases)
        self.assert_output(
            self.count(lint="skipped"), 0,
            "skipped: lint: its tools are those of Debian 12",
            "skipped: C.a: no FMA", "skipped: C.b: disabled",
            "3 passed, 0 failed, 3 skipped",
        )  # fmt: skip

    def test_lint_counts(self) -> None:
        self.assert_output(self.count(lint="failed"), 1, "FAILED: lint", "4 passed, 1 failed")

    def test_registered_ones_without_a_case(self) -> None:
        results = self.result("rostest-test_toy.xml", "")
        for present in (True, False):
            if not present:
                results.unlink()
            process = self.count("--ran", "build", "run_tests")
            line = f"FAILED: {results}: has no test that ran"
            self.assert_output(process, 1, line, "4 passed, 1 failed")
        # Not asked for.
        process = self.count("--ran", "build", "run_tests_pusht_toy_gtest")
        self.assert_output(process, 0, "4 passed, 0 failed")

    def test_results_that_are_asked_for_by_name(self) -> None:
        path = self.result("other.xml", CASE)
        arguments = ("--result", str(path), "--ran", "build", "run_tests")
        self.assert_output(self.count(*arguments), 0, "6 passed, 0 failed")
        path.unlink()
        line = f"FAILED: {path}: has no test that ran"
        self.assert_output(self.count(*arguments), 1, line, "5 passed, 1 failed")

    def test_files_that_nothing_runs(self) -> None:
        """Catkin leaves out all tests of a sort whose tool is missing."""
        self.write("build/CTestTestfile.cmake", "")
        for results, *files in (
            ("gtest-toy_test.xml", "toy_test.cpp"),
            ("pytest-test.test_toy.py.xml", "panel_test.cpp", "test_toy.py"),
            ("rosunit-live_toy.xml", "live_toy.py", "toy.test"),
        ):
            path = self.result(results, "")
            lines = [f"FAILED: src/pusht_toy/test/{file}: has no test that ran" for file in files]
            self.assert_output(self.count(), 1, *lines, f"4 passed, {len(files)} failed")
            path.unlink()
            self.assertEqual(self.count().returncode, 1)
            self.result(results, self.RESULTS[results])

    def test_reports_of_sanitizers(self) -> None:
        self.write("build/address/CTestTestfile.cmake", "")
        self.write("build/address/reports/report.7", "leak of 8 bytes\n")
        process = self.count("--ran", "build", "run_tests", "--ran", "build/address", "run_tests")
        report = "FAILED: sanitizer's report build/address/reports/report.7"
        self.assert_output(process, 1, report, "leak of 8 bytes", "", "5 passed, 1 failed")


class Compare(ScriptCase):
    def test_empty_argument_is_refused(self) -> None:
        """It may be a variable of a shell that is not set."""
        process = self.run_in_folder(str(ROOT / "script" / "compare"), "episodes:=2", "out:=")
        self.assertEqual(process.returncode, 2, process.stdout)
        self.assertEqual(process.stdout, "compare: out '': must not be empty; leave it out\n")


class Docs(ScriptCase):
    """script/docs, of this project, and of one with a single header."""

    HEADER = "// SPDX-License-Identifier: BSD-3-Clause\n/// Toys.\n#pragma once\n\n"

    def docs(self, header: str) -> "subprocess.CompletedProcess[str]":
        for name in ("script/environment", "script/docs", "docs/Doxyfile"):
            self.write(name, (ROOT / name).read_text())
            shutil.copymode(ROOT / name, self.folder / name)
        self.write("script/setup", "#!/usr/bin/env bash\n").chmod(0o755)
        self.write("src/toys/package.xml", "<description>Toys to play with.</description>\n")
        self.write("src/toys/include/toys/toy.hpp", self.HEADER + header)
        return self.run_in_folder("script/docs")

    def test_pages_have_the_comments(self) -> None:
        process = self.docs("/// A thing that rolls.\nstruct Toy {\n  int wheels;\n};\n")
        self.assertEqual(process.returncode, 0, process.stdout)
        index = Path(process.stdout.strip())
        self.assertIn("Toys to play with.", index.read_text())
        self.assertIn("A thing that rolls.", (index.parent / "structToy.html").read_text())
        self.assertIn("toy_8hpp.html", (index.parent / "group__toys.html").read_text())

    def test_what_lacks_a_sentence_is_named(self) -> None:
        for name, text, complaint in (
            (
                "a class",
                "struct Toy {\n  int wheels;\n};\n",
                "toy.hpp:5: warning: Compound Toy is not documented",
            ),
            (
                "a free function",
                "/// Toys.\nnamespace toys {\nvoid roll();\n}\n",
                "toy.hpp:7: warning: Member roll() (function) of namespace toys is not documented",
            ),
            (
                "what is no HTML",
                "/// The <toy> rolls.\nstruct Toy {};\n",
                "Unsupported xml/html tag <toy>",
            ),
        ):
            with self.subTest(name):
                process = self.docs(text)
                self.assertEqual(process.returncode, 1, process.stdout)
                self.assertIn(complaint, process.stdout)


class Environment(ScriptCase):
    """The functions that scripts share."""

    def bash(self, command: str, **environment: str) -> "subprocess.CompletedProcess[str]":
        source = f"source {ROOT}/script/environment"
        variables = [f"{name}={value}" for name, value in environment.items()]
        return self.run_in_folder("env", *variables, "bash", "-c", f"{source}; {command}")

    def test_comparison_needs_the_packages_of_its_kinds_views_and_files(self) -> None:
        for arguments, display, packages in (
            ("", "", {"pusht_mujoco", "pusht_engine"}),
            ("", ":0", {"pusht_mujoco", "pusht_engine", "pusht_rviz"}),
            ("rviz:=False", ":0", {"pusht_mujoco", "pusht_engine"}),
            ("rviz:=false rviz:=1", ":0", {"pusht_mujoco", "pusht_engine", "pusht_rviz"}),
            ("engine:=auto reference:=auto", "", {"pusht_mujoco", "pusht_engine"}),
            ("engine:=bullet reference:=box2d", "", {"pusht_bullet", "pusht_box2d"}),
            ("'engine:=.*'", "", {"pusht_mujoco"}),
            ("report:=True", "", {"pusht_mujoco", "pusht_engine", "sim2sim_report"}),
            ("policy:=my.onnx", "", {"pusht_mujoco", "pusht_engine", "onnx"}),
        ):
            with self.subTest(arguments=arguments, display=display):
                process = self.bash(f"needs_of_comparison {arguments}", DISPLAY=display)
                self.assertEqual(set(process.stdout.split()), packages)

    def test_box_around_a_good_end_is_left_out(self) -> None:
        line = "=" * 80
        for end, shown in (("has finished cleanly", False), ("has died [exit code -11]", True)):
            box = f"\033[31m{line}REQUIRED process [sim2sim-5] has died!\nprocess {end}\n"
            box += f"Initiating shutdown!\n{line}\033[0m\n"
            self.write("said", f"before\n{box}after\n")
            process = self.bash("without_good_ends <said")
            self.assertEqual(process.stdout, f"before\n{box if shown else ''}after\n")

    def test_work_that_fails_shows_its_end_and_returns_its_code(self) -> None:
        work = "printf 'Scanning dependencies\\n[ 50%%] Building\\nerror: no\\n'; exit 7"
        process = self.bash(f'with_progress "$PWD/log" bash -c "{work}" || echo "returned $?"')
        log = self.folder / "log"
        failed = f"bash: failed with exit code 7; all of its output is in {log}"
        self.assertEqual(process.stdout.splitlines(), ["error: no", failed, "returned 7"])
        self.assertIn("[ 50%] Building", log.read_text())
        alone = self.bash(f'with_progress "$PWD/log" bash -c "{work}"')
        self.assertEqual(alone.returncode, 7)
        self.assertIn("error: no", alone.stdout)

    def test_progress_is_shown_at_every_tenth(self) -> None:
        """Also where make steps over it; nothing of what ends within seconds."""
        steps = "".join(f"[{share:3}%] Building\n" for share in (2, 9, 13, 17, 24, 47, 100))
        self.write("said", steps)
        process = self.bash("show_progress 0 <said")
        shown = [line.split(",")[0] for line in process.stdout.splitlines()]
        self.assertEqual(shown, [f"compiling: {share} %" for share in (13, 24, 47, 100)])
        self.assertEqual(self.bash("show_progress 3 <said").stdout, "")


class Container(ScriptCase):
    """The recipe names what there is, and its entry runs in the workspace."""

    def setUp(self) -> None:
        super().setUp()
        lines = (ROOT / "script" / "Containerfile").read_text().splitlines()
        steps = [line.split(" ", 1) for line in lines if line and not line.startswith(("#", " "))]
        self.steps = {name: text for name, text in steps}

    def test_steps_are_those_of_a_newcomer(self) -> None:
        release = self.steps["FROM"].split(":")[1]
        self.assertIn(f"!= {release}", (ROOT / "script" / "lint").read_text(), "the tools' release")
        self.assertEqual(self.steps["COPY"], ". /sim2sim")
        script = self.steps["RUN"].replace("/sim2sim", str(ROOT), 1)
        self.assertTrue(os.access(script, os.X_OK), script)

    def test_entry_runs_in_the_workspace(self) -> None:
        entry = [
            text.replace("/sim2sim", str(ROOT)) for text in json.loads(self.steps["ENTRYPOINT"])
        ]
        found = self.run_in_folder(*entry, "rospack", "find", "sim2sim_eval")
        self.assertEqual(found.stdout.strip(), str(ROOT / "src" / "sim2sim_eval"))
        node, package, launch = json.loads(self.steps["CMD"])[:3]
        self.assertEqual((node, package), ("roslaunch", "sim2sim_eval"))
        self.assertTrue((ROOT / "src" / package / "launch" / launch).is_file())


class Lint(ScriptCase):
    """script/lint in a repository of its own, where the script `deploy` has a fault."""

    FAULTY = "#!/usr/bin/env bash\ncd $1\n"
    SOUND = '#!/usr/bin/env bash\ncd "$1" || exit\n'

    def setUp(self) -> None:
        super().setUp()
        for name in ("environment", "lint"):
            self.write(f"script/{name}", (ROOT / "script" / name).read_text())
            shutil.copymode(ROOT / "script" / name, self.folder / "script" / name)
        # What it calls, and looks into.
        for name in ("setup", "docs"):
            self.write(f"script/{name}", "#!/usr/bin/env bash\n").chmod(0o755)
        (self.folder / "src").mkdir()
        self.write(".gitignore", "build/\n")
        self.git("init", "--quiet", "--initial-branch=main")

    def git(self, *arguments: str) -> None:
        process = self.run_in_folder("git", "-c", "user.name=t", "-c", "user.email=t", *arguments)
        self.assertEqual(process.returncode, 0, process.stdout)

    def commit(self, deploy: str) -> None:
        self.write("script/deploy", deploy)
        self.git("add", "--all")
        self.git("commit", "--quiet", "--message=deploy")

    def assert_lint(self, finds_fault: bool, *options: str) -> None:
        process = self.run_in_folder("script/lint", *options)
        if "VERSION_CODENAME=bookworm" not in Path("/etc/os-release").read_text():
            self.assertRegex(process.stdout, r"\Alint: skipped: .* Debian 12, and this is .+\n\Z")
            self.assertEqual(process.returncode, 77)
            return
        self.assertEqual(process.returncode, int(finds_fault), process.stdout)
        self.assertEqual("lint: shellcheck FAILED" in process.stdout, finds_fault, process.stdout)

    def test_clang_tidy_has_our_checks_and_its_findings_fail(self) -> None:
        """In a source and in a header of ours; not in a header of others."""
        if "VERSION_CODENAME=bookworm" not in Path("/etc/os-release").read_text():
            self.skipTest("style is checked with the tools of Debian 12")
        for name in (".clang-format", ".clang-tidy"):
            self.write(name, (ROOT / name).read_text())
        package = "src/pusht_toy"
        header = self.write(f"{package}/include/pusht_toy/toy.hpp", "constexpr int kToys = 3;\n")
        self.write("others/other.hpp", "constexpr int Foreign = 4;\n")
        text = '#include "pusht_toy/toy.hpp"\n\n#include "other.hpp"\n\nint toys() {\n  '
        sound = "const int toys = kToys + Foreign;\n  return toys;\n}\n"
        source = self.write(f"{package}/src/toy.cpp", text + sound)
        compiler = f"c++ -std=c++17 -I{self.folder}/{package}/include -I{self.folder}/others"
        entry = {
            "directory": str(self.folder),
            "command": f"{compiler} -o CMakeFiles/toy.dir/src/toy.cpp.o -c {source}",
            "file": str(source),
        }
        self.write("build/compile_commands.json", json.dumps([entry]))
        self.write("build/CMakeCache.txt", "")

        def lint() -> str:
            output = self.run_in_folder("script/lint").stdout
            self.assertIn("lint: clang-format ok", output)
            return output

        self.commit(self.SOUND)
        self.assertIn("lint: clang-tidy ok", lint())
        source.write_text(text + sound.replace("toys ", "BadName ").replace(" toys;", " BadName;"))
        output = lint()
        self.assertIn("lint: clang-tidy FAILED", output)
        self.assertIn("toy.cpp:6:13: error: invalid case style for", output)
        source.write_text(text + sound)
        header.write_text("constexpr int kToys = 3;\nconstexpr int BadName = 5;\n")
        output = lint()
        self.assertIn("lint: clang-tidy FAILED", output)
        self.assertIn("toy.hpp:2:15: error: invalid case style for", output)
        self.assertIn("lint: API pages ok", output)  # of a header that changed

    def test_source_that_nothing_compiles_is_named(self) -> None:
        if "VERSION_CODENAME=bookworm" not in Path("/etc/os-release").read_text():
            self.skipTest("style is checked with the tools of Debian 12")
        self.write("build/CMakeCache.txt", "")
        self.write("build/compile_commands.json", "[]")
        self.write("script/build", "#!/usr/bin/env bash\n").chmod(0o755)  # CMake finds it neither
        source = self.write("src/pusht_toy/src/toy.cpp", "int toys() { return 3; }\n")
        self.commit(self.SOUND)
        process = self.run_in_folder("script/lint")
        self.assertEqual(process.returncode, 1, process.stdout)
        self.assertIn(f"not compiled by anything, so not read: {source}", process.stdout)

    def test_reads_what_changed_since_the_commit_that_is_known_to_be_clean(self) -> None:
        self.commit(self.FAULTY)
        self.assert_lint(True)
        self.assert_lint(True)  # it has not passed
        known = self.run_in_folder("git", "rev-parse", "HEAD").stdout
        self.write(".ci/lint_clean", known)
        self.git("add", "--all")
        self.git("commit", "--quiet", "--message=clean")
        self.assert_lint(False)  # whatever is in it
        self.write("script/other", self.FAULTY)
        self.assert_lint(True)

    def test_reads_what_changed_since_it_passed(self) -> None:
        self.commit(self.SOUND)
        self.assert_lint(False)
        self.commit(self.FAULTY)
        self.assert_lint(True)

    def test_all_files_are_read_on_demand(self) -> None:
        self.commit(self.FAULTY)
        known = self.run_in_folder("git", "rev-parse", "HEAD").stdout
        self.write(".ci/lint_clean", known)
        self.assert_lint(False)
        self.assert_lint(True, "--all")

    def test_commit_that_is_not_there_is_not_known(self) -> None:
        self.commit(self.FAULTY)
        self.write(".ci/lint_clean", "0" * 40 + "\n")
        self.assert_lint(True)

    def test_pass_with_uncommitted_changes_is_not_remembered(self) -> None:
        self.commit(self.FAULTY)
        self.write("script/deploy", self.SOUND)
        self.assert_lint(False)
        self.write("script/deploy", self.FAULTY)
        self.assert_lint(True)


if __name__ == "__main__":
    unittest.main()
