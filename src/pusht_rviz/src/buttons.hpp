// SPDX-License-Identifier: BSD-3-Clause
/// Rule for the buttons of a run: which make sense in which situation. Without widgets.
#pragma once

#include <string>

namespace pusht_rviz {

/// State of evaluator, run and form that the buttons depend on.
struct Situation {
  bool reachable = false;   ///< the service `control` answers
  bool compares = false;    ///< the action `compare` has a server
  bool asked = false;       ///< a goal was sent, and is not answered yet
  bool busy = false;        ///< as in Progress
  bool paused = false;      ///< as in Progress
  bool replay = false;      ///< as in Progress
  bool cancelling = false;  ///< the run under way was told to end
  std::string waits_for;    ///< message that the form of the next run waits for, in words; empty: none
  std::string refusal;      ///< first rule that the form of the next run breaks; empty: none
};

/// Buttons that are enabled.
struct Buttons {
  bool start = false;
  bool pause = false;
  bool resumes = false;  ///< the button Pause resumes
  bool step = false;
  bool cancel = false;
  bool rate = false;
  std::string why_not;  ///< reason why Start is disabled; empty: it is enabled
};

/// State of the buttons in a situation of the run.
Buttons buttonsFor(const Situation& situation);

}  // namespace pusht_rviz
