// SPDX-License-Identifier: BSD-3-Clause
/// How whoever runs a measurement is asked to end, and how it is warned of something.
#pragma once

#include <string>

namespace sim2sim {

/// From now on the first SIGINT, SIGTERM or SIGHUP asks for an end in order: interrupted() holds. A second one
/// (half a second later, or more), or 10 s without such an end, ends the process at once, with a line of `name` and
/// exit code 4: code that is not ours may never return. What is under way then is lost; files are complete or absent
/// all the same.
void catchInterrupts(const std::string& name);
/// The same, but signals never break off a call of this thread or of those that it starts from now on: roscpp takes
/// such a call of the master for a master that is not there, or a parameter that is not set.
void catchInterruptsAside(const std::string& name);
/// Whether a signal has asked for the end of the process.
bool interrupted();

/// Throws RuntimeFault if interrupted() holds: "interrupted in row 3". A command calls it between the pieces of its
/// work, and once more before it prints or writes what it has found.
void requireNotInterrupted(const std::string& where = "");

/// Says so on stderr, unless `warning` is empty.
void warn(const std::string& warning);

}  // namespace sim2sim
