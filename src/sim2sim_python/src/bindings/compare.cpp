// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/stl.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <filesystem>
#include <functional>
#include <future>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "bindings.hpp"
#include "policy_desk.hpp"
#include "pusht_task/error.hpp"
#include "python_policy.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/comparison.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/episodes_csv.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "without_gil.hpp"

namespace sim2sim::python {
namespace {

namespace py = pybind11;

/// A callable of Python as compare() of the package describes it.
struct CallablePolicy {
  py::object policy;    ///< None: the policy is one of the suite, by its name
  std::string name;     ///< for people: "examples.charge"
  std::string version;  ///< empty: none
  int history = 0;
};

/// Time between two looks at the signals that Python has got, while no query comes.
constexpr std::chrono::milliseconds kSignalPeriod{50};

/// Time for a run to end with the interpreter; its callable may not return.
constexpr std::chrono::seconds kLeavingPatience{10};

/// Whether a run is under way in this process, and whether the interpreter ends.
struct Runs {
  std::mutex mutex;
  std::condition_variable changed;
  bool is_running = false;
  std::atomic<bool> is_leaving = false;
};

Runs& runs() {
  static Runs runs;
  return runs;
}

/// The right to run, and to take the warnings of the process. Throws InvalidInput if another run has it.
class OneRun {
 public:
  explicit OneRun(std::function<void(const std::string&)> take_warning) {
    const std::lock_guard<std::mutex> lock(runs().mutex);
    if (runs().is_running) {
      throw pusht::InvalidInput("compare: runs already in this process; must not be called beside itself");
    }
    runs().is_running = true;
    sendWarningsTo(std::move(take_warning));
  }
  OneRun(const OneRun&) = delete;
  OneRun& operator=(const OneRun&) = delete;
  ~OneRun() {
    sendWarningsTo({});
    const std::lock_guard<std::mutex> lock(runs().mutex);
    runs().is_running = false;
    runs().changed.notify_all();
  }
};

/// Ends the run of a daemon thread before the interpreter ends: later, a thread that wants the GIL is killed within
/// C++.
void leave() {
  {
    const py::gil_scoped_release released;
    runs().is_leaving = true;
    std::unique_lock<std::mutex> lock(runs().mutex);
    runs().changed.wait_for(lock, kLeavingPatience, [] { return !runs().is_running; });
  }
  endWithoutGil();
}

/// A comparison in a thread of its own, and its service in the thread that called Python's compare().
class ServedComparison {
 public:
  ServedComparison(CompareOptions options, const CallablePolicy& callable, bool files, bool progress)
      : options_(std::move(options)) {
    host_.files = files;
    host_.progress = progress;
    host_.out = &text_;
    host_.stop = [this] { return stop_.load(); };
    if (!callable.policy.is_none()) {
      callable_.emplace(callable.policy, callable.name, callable.history);
      name_ = callable.name;
      host_.policy_can_return = !callable.version.empty();
      host_.choose_policy = [chosen = chosenFrom(callable)] { return chosen; };
    }
  }

  /// Runs it. Throws what the comparison throws; what the callable raises, a warning that is an error, or a signal's
  /// exception, as itself.
  ComparisonResults run() {
    const OneRun one_run([this](const std::string& warning) { desk_.warn(warning); });
    std::future<void> run = std::async(std::launch::async, [this] { compareAside(); });
    serve();
    {
      const py::gil_scoped_release released;
      run.wait();
    }
    desk_.releaseDropped();
    if (raised_) {
      std::rethrow_exception(raised_);
    }
    if (failure_) {
      std::rethrow_exception(failure_);
    }
    return std::move(*result_);
  }

  std::string text() const { return text_.str(); }

 private:
  pusht::ChosenPolicy chosenFrom(const CallablePolicy& callable) {
    const py::object python = py::module_::import("platform").attr("python_version")();
    nlohmann::json identity = {{"python", callable.name}, {"version", callable.version}, {"history", callable.history}};
    nlohmann::json provenance = {
        {"runs_on", "Python " + std::string(py::str(python))},
        {"callable", callable.name},
        {"history", callable.history},
        {"version", callable.version.empty() ? nlohmann::json() : nlohmann::json(callable.version)},
        {"note", "a Python callable: known by its name and version, not by its code"}};
    return {[this, history = callable.history] { return std::make_unique<PythonPolicy>(desk_, std::max(history, 1)); },
            "python:" + callable.name,
            identity,
            provenance,
            {},
            ""};
  }

  void compareAside() {
    try {
      result_ = compare(options_, host_);
    } catch (...) {
      failure_ = std::current_exception();
    }
    desk_.end();
  }

  void serve() {
    for (bool ended = false; !ended;) {
      PolicyDesk::Work work;
      {
        const py::gil_scoped_release released;
        work = desk_.wait(kSignalPeriod);
      }
      ended = work.ended;
      try {
        if (PyErr_CheckSignals() != 0) {
          throw py::error_already_set();
        }
        if (runs().is_leaving) {
          throw pusht::RuntimeFault("compare: the interpreter ends");
        }
        for (const std::string& warning : work.warnings) {
          if (PyErr_WarnEx(PyExc_RuntimeWarning, warning.c_str(), 2) != 0) {
            throw py::error_already_set();
          }
        }
        desk_.releaseDropped();
        if (!work.rows.empty()) {
          answer(work.rows);
        }
      } catch (...) {  // not the callable's: a signal's, mostly
        interrupt();
      }
    }
  }

  void answer(const std::vector<Row*>& rows) {
    try {
      callable_->answer(rows);
      desk_.answered();
    } catch (const pusht::Error&) {
      desk_.refuse(std::current_exception());
    } catch (const py::error_already_set& error) {
      if (error.matches(PyExc_KeyboardInterrupt)) {
        throw;
      }
      raised_ = raised_ ? raised_ : std::current_exception();
      const std::string text = error.what();  // a traceback may follow
      desk_.close("policy " + name_ + ": raised " + text.substr(0, text.find('\n')));
    }
  }

  /// Ends the run because of the current exception.
  void interrupt() {
    raised_ = raised_ ? raised_ : std::current_exception();
    stop_ = true;
    desk_.close("interrupted");
  }

  CompareOptions options_;
  ComparisonHost host_;
  std::optional<Callable> callable_;
  std::string name_;
  PolicyDesk desk_;
  std::atomic<bool> stop_ = false;
  std::ostringstream text_;
  std::exception_ptr raised_;
  std::exception_ptr failure_;
  std::optional<ComparisonResults> result_;
};

/// Throws InvalidInput if `options` ask for what cannot be with a Python callable.
void requireFitting(const CompareOptions& options, const CallablePolicy& callable) {
  if (callable.policy.is_none()) {
    return;
  }
  if (options.smoke) {
    throw pusht::InvalidInput("smoke: must be left out: it runs an untrained policy, and none of Python");
  }
  if (!options.batch.reference_cache.empty() && callable.version.empty()) {
    throw pusht::InvalidInput("reference_cache " + options.batch.reference_cache +
                              ": must be left out without a version of the policy: a Python callable is known by its "
                              "name and version, not by its code");
  }
}

py::dict compareInPython(const py::dict& keywords, const py::object& policy, const std::string& name,
                         const std::string& version, int history, bool progress) {
  CompareOptions options;
  CLI::App app("", "compare");
  options.declare(app);
  parseArguments(app, argumentsOf(app, keywords));
  const CallablePolicy callable = {policy, name, version, history};
  requireFitting(options, callable);
  const bool files = !options.out.empty();
  for (std::string* const written : {&options.out, &options.write_starts}) {
    if (!policy.is_none() && !written->empty()) {  // the callable may change folders
      *written = std::filesystem::absolute(*written).string();
    }
  }
  ServedComparison comparison(std::move(options), callable, files, progress);
  const ComparisonResults result = comparison.run();
  py::dict answer;
  answer["episodes"] = episodesCsv(result.configuration.protocol, result.episodes);
  answer["metrics"] = jsonText(result.metrics);
  answer["provenance"] = jsonText(result.provenance);
  answer["text"] = comparison.text();
  answer["folder"] = result.folder.string();
  return answer;
}

}  // namespace

void bindCompare(py::module_& module) {
  module.def("compare", compareInPython, py::arg("options"), py::arg("policy"), py::arg("name"), py::arg("version"),
             py::arg("history"), py::arg("progress"));
  py::module_::import("atexit").attr("register")(py::cpp_function(leave));
}

}  // namespace sim2sim::python
