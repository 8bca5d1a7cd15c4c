// SPDX-License-Identifier: BSD-3-Clause
#include "live/control.hpp"

#include "pusht_task/clipped.hpp"
#include "pusht_task/error.hpp"

namespace sim2sim {

void applyControl(Pacer& pacer, const pusht_msgs::ControlRequest& request) {
  if (request.command == pusht_msgs::ControlRequest::PAUSE) {
    pacer.pause();
  } else if (request.command == pusht_msgs::ControlRequest::RESUME) {
    pacer.resume();
  } else if (request.command == pusht_msgs::ControlRequest::RATE) {
    if (request.rate == 0.0) {
      throw pusht::InvalidInput("rate 0: must be above 0 (control steps per second), or below 0 (as fast as possible)");
    }
    pacer.setRate(request.rate < 0.0 ? 0.0 : request.rate);
  } else if (request.command == pusht_msgs::ControlRequest::STEP) {
    if (!pacer.step()) {
      throw pusht::InvalidInput("step: only while paused");
    }
  } else if (request.command == pusht_msgs::ControlRequest::CANCEL) {
    throw pusht::InvalidInput("cancel: only in a live run");
  } else if (request.command == pusht_msgs::ControlRequest::SEEK) {
    throw pusht::InvalidInput("seek: only in a replay");
  } else {
    throw pusht::InvalidInput("command '" + request.command + "': must be pause, resume, step, rate, cancel or seek");
  }
}

pusht_msgs::ControlResponse controlResponse(const std::function<void()>& serve) {
  pusht_msgs::ControlResponse response;
  try {
    serve();
    response.success = 1;
  } catch (const pusht::InvalidInput& refusal) {
    response.message = pusht::clipped(refusal.what());
  }
  return response;
}

}  // namespace sim2sim
