// SPDX-License-Identifier: BSD-3-Clause
/// An application for widgets, without a screen.
#pragma once

#include <QApplication>
#include <array>
#include <string>

namespace pusht_rviz {

/// The one of this program. (The platform "offscreen" of Qt 5 never frees its own memory.)
inline QApplication& headlessApplication() {
  static const bool headless = qputenv("QT_QPA_PLATFORM", "minimal");
  static int argc = headless ? 1 : 0;
  static std::string name = "pusht_rviz_test";
  static std::array<char*, 2> argv = {name.data(), nullptr};
  static QApplication application(argc, argv.data());
  return application;
}

}  // namespace pusht_rviz
