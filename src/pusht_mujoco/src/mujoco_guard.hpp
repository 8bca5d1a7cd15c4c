// SPDX-License-Identifier: BSD-3-Clause
/// MuJoCo's errors and warnings as exceptions.
#pragma once

#include <csetjmp>
#include <string>

namespace pusht {

/// Runs calls into MuJoCo so that `mju_error`, which must not return, ends in an exception of ours instead
/// of a prompt and an exit. The engine is C: an exception must not cross its frames, so the error handler jumps
/// over them (none has a destructor) and the guard throws. The model compiler is C++, but has a handler of its
/// own. What the call worked on is then in an undefined state and may only be deleted.
class MujocoGuard {
 public:
  /// Throws InternalError with MuJoCo's message if `call` raises mju_error, std::bad_alloc if MuJoCo has no memory.
  /// `call` must not own anything that needs a destructor.
  template <class Call>
  static void run(const Call& call) {
    MujocoGuard guard;
    if (setjmp(guard.recovery_) != 0) {  // NOLINT(cert-err52-cpp): see above
      guard.raise();
    }
    call();
  }

  /// The last warning in this thread, on one line, and forgets it; empty if there was none.
  static std::string takeWarning();

  MujocoGuard(const MujocoGuard&) = delete;
  MujocoGuard& operator=(const MujocoGuard&) = delete;

 private:
  MujocoGuard();
  ~MujocoGuard();
  [[noreturn]] void raise();

  static void onError(const char* message);
  static void onWarning(const char* message);

  std::jmp_buf recovery_;
  MujocoGuard* outer_;
};

}  // namespace pusht
