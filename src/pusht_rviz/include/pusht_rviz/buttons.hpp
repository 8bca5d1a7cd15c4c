// SPDX-License-Identifier: BSD-3-Clause
/// Which buttons make sense, and when.
#pragma once

#include <string>

namespace pusht_rviz {

/// What the panel knows.
struct Situation {
  bool reachable = false;  ///< somebody serves `control`
  bool compares = false;   ///< somebody serves the action `compare`
  bool asked = false;      ///< a goal was sent, and is not answered yet
  bool busy = false;       ///< as in Progress; so are the next two
  bool paused = false;
  bool replay = false;
  bool cancelling = false;  ///< this run is to end
  std::string waits_for;    ///< what has to come before the form of the next run says anything; empty: nothing
  std::string refusal;      ///< the first rule that the form of the next run breaks; empty: none
};

/// Buttons that are enabled.
struct Buttons {
  bool start = false;
  bool pause = false;    ///< or resume
  bool resumes = false;  ///< what the button `pause` does
  bool step = false;
  bool cancel = false;
  bool rate = false;
  std::string why_not;  ///< why there is no start, in words; empty: there is
};

/// State of the buttons in a situation of the run.
Buttons buttonsFor(const Situation& situation);

}  // namespace pusht_rviz
