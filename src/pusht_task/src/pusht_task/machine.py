# SPDX-License-Identifier: BSD-3-Clause
"""The machine that computes."""

import platform


def cpu_model() -> str:
    """Name of the processor, as /proc/cpuinfo has it; "unknown" where it has none."""
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        models = [line.split(":", 1)[1].strip() for line in file if line.startswith("model name")]
    return models[0] if models else platform.processor() or "unknown"
