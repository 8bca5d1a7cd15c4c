# SPDX-License-Identifier: BSD-3-Clause
"""The command behind script/study: the study over policies, or with `noise` the one under noise."""

import sys


def main() -> int:
    """Runs the study that is asked for; each loads what it needs alone."""
    if sys.argv[1:2] == ["noise"]:
        from sim2sim_study import noise

        return noise.main(sys.argv[2:])
    from sim2sim_study import first

    return first.main(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
