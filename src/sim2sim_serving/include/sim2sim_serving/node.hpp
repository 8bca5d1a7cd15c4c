// SPDX-License-Identifier: BSD-3-Clause
/// Frame of every node: start, end, failures.
#pragma once

#include <exception>
#include <functional>
#include <string>

#include "pusht_task/error.hpp"

namespace pusht {

/// Behavior of a node that finds no master at its start.
enum class NoMaster {
  kFail,  ///< exit code 4 and a hint
  kWait,  ///< roscpp says so; the node begins when there is one
};

/// Life of a node.
enum class Life {
  kServes,    ///< until it is ended; may be started again with the parameters that it has on the parameter server
  kRunsOnce,  ///< to its own end, catching signals itself; roslaunch must not start it again, as a launch's private
              ///< parameters go with it
};

/// Starts a node called `name`, runs `body` and returns the process's exit code. A failure is one line on stderr.
/// `body` begins with requireClock() and ends when ros::ok() no longer holds. A master that dies (noticed within 5 s:
/// the node is shut down) and a roslaunch that has started the node and dies (within 1 s) end in exit code 4 and a
/// hint. What the node has set on the parameter server goes with it, unless roslaunch has started it.
int runNode(int argc, char** argv, const std::string& name, NoMaster no_master, const std::function<ExitCode()>& body,
            Life life = Life::kServes);

/// Makes this process, which has a main of its own, a node as well: one of a random name, that leaves signals to the
/// process. Does nothing the next time. Throws RuntimeFault, with a hint, if no master answers.
void becomeNode();

/// Throws RuntimeFault if `use_sim_time` is set and there is no clock. Apart from runNode(), for a node that must leave
/// a word about it.
void requireClock();

/// `failure` on one line of stderr; its exit code. `reporter` is the node or command that failed.
int reportFailure(const std::string& reporter, const std::exception& failure);

/// Random id of an instance of a node; a new one for each call.
std::string newInstanceId();

}  // namespace pusht
