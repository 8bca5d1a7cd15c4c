// SPDX-License-Identifier: BSD-3-Clause
#include "mujoco_guard.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <string>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

/// A message kept in plain storage: it is written by a handler that is left by a jump.
using Message = std::array<char, 1000>;

thread_local MujocoGuard* innermost = nullptr;
thread_local Message last_error{};
thread_local Message last_warning{};

void keep(const char* text, Message& message) {
  std::snprintf(message.data(), message.size(), "%s", text);
  std::replace(message.begin(), message.end(), '\n', ' ');
}

}  // namespace

MujocoGuard::MujocoGuard() : outer_(innermost) {
  mju_user_error = &MujocoGuard::onError;
  mju_user_warning = &MujocoGuard::onWarning;
  innermost = this;
}

MujocoGuard::~MujocoGuard() { innermost = outer_; }

void MujocoGuard::onError(const char* message) {
  keep(message, last_error);
  if (innermost == nullptr) {
    std::fprintf(stderr, "MuJoCo: %s\n", last_error.data());
    std::_Exit(static_cast<int>(ExitCode::kInternalError));
  }
  std::longjmp(innermost->recovery_, 1);  // NOLINT(cert-err52-cpp): see the class comment
}

void MujocoGuard::onWarning(const char* message) { keep(message, last_warning); }

void MujocoGuard::raise() {
  const std::string message = last_error.data();
  if (message.find("ould not allocate") != std::string::npos) {
    throw std::bad_alloc();
  }
  throw InternalError("MuJoCo: " + message);
}

std::string MujocoGuard::takeWarning() {
  std::string warning = last_warning.data();
  last_warning.front() = '\0';
  return warning;
}

}  // namespace pusht
