// SPDX-License-Identifier: BSD-3-Clause
/// A node's health on /diagnostics.
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>

#include <functional>
#include <string>

namespace pusht {

using diagnostic_updater::DiagnosticStatusWrapper;

/// Publishes what `report` says of `what` once a second, on the steady clock.
class Health {
 public:
  Health(const std::string& hardware_id, const std::string& what,
         const std::function<void(DiagnosticStatusWrapper&)>& report) {
    updater_.setHardwareID(hardware_id);
    updater_.add(what, report);
    timer_ = ros::NodeHandle().createSteadyTimer(ros::WallDuration(1.0),
                                                 [this](const ros::SteadyTimerEvent&) { updater_.force_update(); });
  }
  Health(const Health&) = delete;
  Health& operator=(const Health&) = delete;

  void setHardware(const std::string& hardware_id) { updater_.setHardwareID(hardware_id); }

 private:
  diagnostic_updater::Updater updater_;
  ros::SteadyTimer timer_;
};

}  // namespace pusht
