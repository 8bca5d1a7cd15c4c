// SPDX-License-Identifier: BSD-3-Clause
#include "without_gil.hpp"

#include <unistd.h>

#include <condition_variable>
#include <mutex>

namespace sim2sim::python {
namespace {

struct Threads {
  std::mutex mutex;
  std::condition_variable changed;
  int without = 0;  // threads between the release of the GIL and its return
  bool is_ending = false;

  void count(int change) {
    const std::lock_guard<std::mutex> lock(mutex);
    without += change;
    changed.notify_all();
  }

  /// Whether a thread may take the GIL back; if not, it is counted no more.
  bool mayReturn() {
    const std::lock_guard<std::mutex> lock(mutex);
    if (is_ending) {
      --without;
      changed.notify_all();
    }
    return !is_ending;
  }
};

Threads& threads() {
  static Threads threads;
  return threads;
}

}  // namespace

WithoutGil::WithoutGil() {
  const std::lock_guard<std::mutex> lock(threads().mutex);
  if (!threads().is_ending) {
    ++threads().without;
    released_.emplace();
  }
}

WithoutGil::~WithoutGil() {
  if (!released_) {
    return;
  }
  if (!threads().mayReturn()) {
    while (true) {
      ::pause();
    }
  }
  released_.reset();  // the interpreter's end waits for it
  threads().count(-1);
}

void endWithoutGil() {
  const pybind11::gil_scoped_release released;
  std::unique_lock<std::mutex> lock(threads().mutex);
  threads().is_ending = true;
  threads().changed.wait(lock, [] { return threads().without == 0; });
}

}  // namespace sim2sim::python
