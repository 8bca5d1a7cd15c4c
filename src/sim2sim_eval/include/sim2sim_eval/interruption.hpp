// SPDX-License-Identifier: BSD-3-Clause
/// Signals that ask a measurement to end, and warnings.
#pragma once

#include <functional>
#include <string>

namespace sim2sim {

/// Catches kEndingSignals from now on. The first one asks for an end in order: interrupted() holds. A
/// second one (half a second later, or more), or 10 s without such an end, ends the process at once, with a line of
/// `name` and exit code 4, because code that is not ours may never return. Work under way is then lost; files are
/// complete or absent all the same.
void catchInterrupts(const std::string& name);

/// Catches them in a thread of its own, so that they never break off a call of this thread or of threads that it starts
/// from now on: roscpp takes an interrupted call of the master for a master that is not there.
void catchInterruptsAside(const std::string& name);

/// Whether a signal, or interrupt(), has asked for the end of the process's work.
bool interrupted();

/// Asks for it as a signal does, for a program that catches signals itself; false: takes it back, so that further work
/// can begin.
void interrupt(bool wanted);

/// Throws RuntimeFault if interrupted() holds: "interrupted in row 3". A command calls it between the pieces of its
/// work, and once more before it prints or writes what it has found.
void requireNotInterrupted(const std::string& where = "");

/// Prints `warning` to stderr, unless it is empty.
void warn(const std::string& warning);

/// Hands the warnings of this process, in whichever thread they come up, to `take` instead; empty: to stderr again. To
/// be called while no other thread warns.
void sendWarningsTo(std::function<void(const std::string&)> take);

}  // namespace sim2sim
