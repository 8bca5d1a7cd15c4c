#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The success rate of a checkpoint, from a comparison into its provenance."""

import json
import subprocess
import unittest
from typing import Any, Dict
from unittest import mock

from command_case import CommandCase, executable
from pusht_policy.checkpoint import provenance_path, sha256_of
from pusht_task.error import Error
from sim2sim_eval.evaluation import record_evaluation
from sim2sim_report.results import METRICS_FORMAT

RECORD_EVALUATION = executable("sim2sim_eval", "record_evaluation")


class RecordEvaluation(CommandCase):
    def setUp(self) -> None:
        super().setUp()
        self.out = self.folder / "policy.ts.pt"
        self.out.write_bytes(b"weights")
        self.provenance = provenance_path(self.out)
        found = sha256_of(self.out)
        self.provenance.write_text(json.dumps({"checkpoint": {"sha256": found}}))
        configuration: Dict[str, Any] = {
            "format": METRICS_FORMAT,
            "episodes": 50,
            "seed": 0,
            "first_episode": 0,
            "horizon": 300,
            "smoke": False,
            "reference_simulator": "mujoco",
            "simulators": {"reference": {"changed": []}},
        }
        self.metrics = {**configuration, "mj_success_rate": 0.62, "mj_successes": 31}
        self.origin: Dict[str, Dict[str, Any]] = {
            "configuration": configuration,
            "policy": {"sha256": found},
            "reference": {"version": "2.2.2"},
        }

    def write_results(self) -> None:
        for name, content in (("metrics", self.metrics), ("provenance", self.origin)):
            (self.folder / f"{name}.json").write_text(json.dumps(content))

    def record(self) -> "subprocess.CompletedProcess[str]":
        self.write_results()
        return self.run_command(RECORD_EVALUATION, str(self.out), str(self.folder))

    def test_success_rate_is_recorded(self) -> None:
        finished = self.record()
        self.assertEqual((finished.returncode, finished.stderr), (0, ""))
        self.assertEqual(
            json.loads(self.provenance.read_text())["evaluation"],
            {
                "simulator": "MuJoCo 2.2.2",
                "episodes": 50,
                "seed": 0,
                "success_rate": 0.62,
                "successes": 31,
            },
        )

    def test_refusals_change_nothing(self) -> None:
        before = self.provenance.read_bytes()

        def refused(text: str) -> None:
            finished = self.record()
            self.assert_one_line(finished, 2, "record_evaluation")
            self.assertIn(text, finished.stderr)
            self.assertEqual(self.provenance.read_bytes(), before)

        others: Dict[str, Any] = {
            "horizon": 200,
            "first_episode": 50,
            "smoke": True,
            "starts": "0123abcd",
            "until_decided": 0.5,
            "repeats": 2,
            "noise_seed": 7,
            "independent_noise": True,
            "execute": 4,
            "simulators": {"reference": {"changed": ["scene"]}},
        }
        for name, value in others.items():
            metrics, configuration = self.metrics, self.origin["configuration"]
            self.metrics = {**metrics, name: value}
            self.origin["configuration"] = {**configuration, name: value}
            self.write_results()
            with self.assertRaisesRegex(Error, f"provenance.json: configuration.{name}"):
                record_evaluation(self.out, self.folder)
            self.metrics, self.origin["configuration"] = metrics, configuration
        self.assertEqual(self.provenance.read_bytes(), before)

        with mock.patch("pusht_policy.checkpoint.PROVENANCE_FORMAT", 2):
            with self.assertRaisesRegex(Error, "provenance.json: format 1: must be 2"):
                record_evaluation(self.out, self.folder)

        self.metrics["format"] -= 1
        ours = METRICS_FORMAT
        refused(f"metrics.json: format {ours - 1}: must be {ours}")
        self.metrics["format"] = ours
        self.metrics["mj_success_rate"] = 0.63
        refused("mj_success_rate is 0.63")
        del self.metrics["mj_success_rate"]
        refused("no key mj_success_rate")
        self.metrics["seed"] = 7
        refused("metrics.json: seed is 7; it must be 0")
        self.origin["configuration"]["reference_simulator"] = "mine"
        refused("configuration.reference_simulator is mine; it must be mujoco")
        self.origin["policy"] = {"sha256": "0" * 64}
        refused("provenance.json: policy.sha256 is 0000")
        self.origin["policy"] = {"runs_on": "scripted"}
        refused("provenance.json: no key policy.sha256")
        self.out.write_bytes(b"other weights")
        refused("checkpoint.sha256 is ")


if __name__ == "__main__":
    unittest.main()
