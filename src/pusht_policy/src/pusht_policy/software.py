# SPDX-License-Identifier: BSD-3-Clause
"""The software that computes weights: versions, and the code that it chooses on this processor."""

import ctypes
import os
import platform
import re
from pathlib import Path
from typing import Dict, List

import numpy as np
import torch

from pusht_policy.recipe import Recipe
from pusht_task.machine import cpu_model

M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3  # of mallopt(3)


def software() -> Dict[str, str]:
    """Versions of what computes the weights, and what they choose their code by."""
    return {
        "cpu": cpu_model(),
        "vectors": _torch_vectors(),
        "blas_core": ", ".join(_blas_cores()) or "unknown",
        "python": platform.python_version(),
        "torch": torch.__version__,
        "numpy": np.__version__,
        "blas": ", ".join(Path(name).name for name in _loaded_blas()) or "unknown",
    }


def set_up_torch(recipe: Recipe) -> None:
    """Makes torch deterministic, free of slow denormals, and keeps what it frees. OpenBLAS has its
    own thread count."""
    torch.use_deterministic_algorithms(True)
    torch.set_flush_denormal(True)
    torch.set_num_threads(recipe.threads)
    for name in _loaded_blas():
        set_threads = getattr(ctypes.CDLL(name), "openblas_set_num_threads", None)
        if set_threads is not None:
            set_threads(ctypes.c_int(recipe.threads))
    _keep_freed_memory()


def _keep_freed_memory() -> None:
    """Tells glibc to keep what is freed: each step of Adam allocates what the last one freed, and
    returning pages to the system in between costs more than the arithmetic."""
    libc = ctypes.CDLL(None)
    for parameter, limit in ((M_TRIM_THRESHOLD, 1 << 30), (M_MMAP_THRESHOLD, 1 << 25)):  # [bytes]
        libc.mallopt(parameter, limit)


def _torch_vectors() -> str:
    """The instruction set that libtorch's own code takes, e.g. AVX2."""
    found = re.search(r"CPU capability usage: (\S+)", torch.__config__.show())
    return found.group(1) if found else "unknown"


def _blas_cores() -> List[str]:
    """The processor types for which OpenBLAS has chosen its code."""
    cores = []
    for name in _loaded_blas():
        core_name = getattr(ctypes.CDLL(name), "openblas_get_corename", None)
        if core_name is not None:
            core_name.restype = ctypes.c_char_p
            cores.append(core_name().decode())
    return sorted(set(cores))


def _loaded_blas() -> List[str]:
    """Real paths of the BLAS libraries that this process has loaded."""
    with open("/proc/self/maps", encoding="utf-8") as maps:
        mapped = {line.split(maxsplit=5)[5].strip() for line in maps if len(line.split()) > 5}
    names = {name for name in mapped if "blas" in Path(name).name and ".so" in Path(name).name}
    return sorted(os.path.realpath(name) for name in names)
