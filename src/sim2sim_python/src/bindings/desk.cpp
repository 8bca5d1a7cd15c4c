// SPDX-License-Identifier: BSD-3-Clause
#include "desk.hpp"

#include <utility>

#include "pusht_task/error.hpp"

namespace sim2sim::python {

void Desk::ask(const std::vector<Row*>& rows) { ask(Query{&rows}); }

void Desk::call(const std::string& name, const std::function<void()>& work) {
  Call call{name, work};
  ask(Query{nullptr, &call});
  if (call.error) {
    std::rethrow_exception(call.error);
  }
}

void Desk::ask(Query query) {
  std::unique_lock<std::mutex> lock(mutex_);
  if (closed_) {
    throw pusht::RuntimeFault(*closed_);
  }
  waiting_.push_back(&query);
  work_.notify_one();
  answers_.wait(lock, [&] { return query.answered; });
  if (query.error) {
    std::rethrow_exception(query.error);
  }
}

void Desk::drop(PyObject* memory) {
  const std::lock_guard<std::mutex> lock(mutex_);
  dropped_.push_back(memory);
}

void Desk::warn(const std::string& warning) {
  const std::lock_guard<std::mutex> lock(mutex_);
  warnings_.push_back(warning);
  work_.notify_one();
}

void Desk::end() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ended_ = true;
  work_.notify_one();
}

Desk::Work Desk::wait(std::chrono::milliseconds patience) {
  std::unique_lock<std::mutex> lock(mutex_);
  work_.wait_for(lock, patience, [this] { return !waiting_.empty() || !warnings_.empty() || ended_; });
  in_hand_ = std::exchange(waiting_, {});
  Work work{{}, {}, std::exchange(warnings_, {}), ended_};
  for (const Query* query : in_hand_) {
    if (query->call != nullptr) {
      work.calls.push_back(query->call);
    } else {
      work.rows.insert(work.rows.end(), query->rows->begin(), query->rows->end());
    }
  }
  return work;
}

void Desk::answered() {
  const std::lock_guard<std::mutex> lock(mutex_);
  finish(nullptr);
}

void Desk::refuse(std::exception_ptr error) {
  const std::lock_guard<std::mutex> lock(mutex_);
  finish(error);
}

void Desk::close(const std::string& reason) {
  const std::lock_guard<std::mutex> lock(mutex_);
  closed_ = reason;
  in_hand_.insert(in_hand_.end(), waiting_.begin(), waiting_.end());
  waiting_.clear();
  finish(std::make_exception_ptr(pusht::RuntimeFault(reason)));
}

void Desk::finish(const std::exception_ptr& error) {
  for (Query* query : in_hand_) {
    query->error = error;
    query->answered = true;
  }
  in_hand_.clear();
  answers_.notify_all();
}

void Desk::releaseDropped() {
  std::vector<PyObject*> dropped;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    dropped = std::exchange(dropped_, {});
  }
  for (PyObject* memory : dropped) {  // what they do when they go may take any time
    Py_DECREF(memory);
  }
}

}  // namespace sim2sim::python
