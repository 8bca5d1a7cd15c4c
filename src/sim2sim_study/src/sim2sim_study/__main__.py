# SPDX-License-Identifier: BSD-3-Clause
"""The command behind script/study: the study over policies, or with `noise` the one under noise."""

import sys

from sim2sim_study import first, noise


def main() -> int:
    if sys.argv[1:2] == ["noise"]:
        return noise.main(sys.argv[2:])
    return first.main(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
