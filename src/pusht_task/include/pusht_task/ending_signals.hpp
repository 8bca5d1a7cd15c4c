// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <csignal>

namespace pusht {

/// Signals that ask a command to end in order: those of a terminal and of its loss, and those by which batch systems
/// warn of a limit of time (Slurm's --signal, Grid Engine's -notify). command.py has the same.
inline constexpr std::array<int, 5> kEndingSignals{SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2};

}  // namespace pusht
