# SPDX-License-Identifier: BSD-3-Clause
from catkin_pkg.python_setup import generate_distutils_setup  # type: ignore[import]
from setuptools import setup  # type: ignore[import]

setup(
    **generate_distutils_setup(
        packages=["sim2sim"],
        package_dir={"": "src"},
        package_data={"sim2sim": ["*.pyi", "py.typed"]},
    )
)
