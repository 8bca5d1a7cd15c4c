// SPDX-License-Identifier: BSD-3-Clause
/// Parameters for messages of tests.
#pragma once

#include <pusht_msgs/Parameter.h>

#include <string>

namespace pusht_rviz {

/// Parameter with this name and value.
inline pusht_msgs::Parameter parameter(const std::string& name, const std::string& value) {
  pusht_msgs::Parameter made;
  made.name = name;
  made.value = value;
  return made;
}

}  // namespace pusht_rviz
