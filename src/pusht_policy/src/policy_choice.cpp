// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/policy_choice.hpp"

#include <sys/resource.h>

#include <boost/dll/runtime_symbol_info.hpp>
#include <chrono>
#include <cstdlib>
#include <string>
#include <system_error>

#include "network_choice.hpp"
#include "planning_expert.hpp"
#include "pusht_policy/scripted_expert.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/library.hpp"
#include "rehearsal.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;

/// Table of functions that a library beside this one exports under `symbol`. The library is loaded at the first use, as
/// network_choice.hpp says why. Throws BadDependency if it is not built, or not that library.
template <class Policies>
const Policies& loadPolicies(const char* file, Library::Scope scope, const char* symbol) {
  const fs::path path = fs::path(boost::dll::this_line_location().string()).replace_filename(file);
  std::error_code ignored;
  if (fs::status(path, ignored).type() == fs::file_type::not_found) {
    throw BadDependency("library " + path.string() + ": cannot be loaded: is not built: script/build builds it");
  }
  const Library library(path, scope);
  const auto* const policies = library.find<Policies>(symbol);
  if (policies == nullptr) {
    throw BadDependency("library " + path.string() + ": has no symbol " + symbol);
  }
  return *policies;
}

/// Global, because torch_network.cpp asks the whole process for the functions of BLAS, to say which one computes.
const NetworkPolicies& networkPolicies() {
  static const auto& policies =
      loadPolicies<NetworkPolicies>(kNetworkPolicyLibrary, Library::Scope::kGlobal, kNetworkPoliciesSymbol);
  return policies;
}

/// Local, so that no other library finds its symbols.
const OnnxPolicies& onnxPolicies() {
  static const auto& policies =
      loadPolicies<OnnxPolicies>(kOnnxPolicyLibrary, Library::Scope::kLocal, kOnnxPoliciesSymbol);
  return policies;
}

/// Planning expert of a task. It plans in gym-pusht's world where that holds the task, else in one that is built from
/// the task's numbers. Throws BadDependency if that kind is not built.
ChosenPolicy planner(const Task& task) {
  const SimulatorKind& kind = SimulatorKinds::installed().named(&task == &gymPusht() ? "gym_pusht" : "rigid_body");
  const SimulatorModel model = kind.load(kind.defaults(task), task);
  return {[make = model.make_world] { return std::make_unique<PlanningExpert>(make()); },
          kPlannerPolicy,
          {{"planner", kind.name}},
          {{"runs_on", "planned in " + kind.title}},
          kind.libraries,
          ""};
}

/// Policy of a file: ONNX by its name, else TorchScript.
ChosenPolicy trained(const fs::path& file, const std::string& name, const std::function<bool()>& stop) {
  return file.extension() == kOnnxExtension ? onnxPolicies().trained(file, name)
                                            : networkPolicies().trained(file, name, stop);
}

/// Runs `load`, which brings libtorch into the process. Where memory is limited (`ulimit -v`), libtorch may abort while
/// it is loaded, and threads of OpenBLAS wait for memory for ever; so a copy of the process tries first, with less.
/// Throws RuntimeFault if that is not enough.
template <class Load>
ChosenPolicy withinMemory(const std::string& what, const std::function<bool()>& stop, const Load& load) {
  constexpr rlim_t kMegabyte = 1'000'000;
  constexpr rlim_t kMargin = 50 * kMegabyte;
  constexpr std::chrono::seconds kDeadline{60};  // libtorch alone takes a second to load, and many on a busy machine
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) {
    return load();
  }
  const std::string cannot =
      what + ": cannot be loaded with " + std::to_string(limit.rlim_cur / kMegabyte) + " MB of memory (ulimit -v): ";
  try {
    rehearse(what, kDeadline, stop, [&] {
      const rlimit less{limit.rlim_cur > kMargin ? limit.rlim_cur - kMargin : 0, limit.rlim_max};
      setrlimit(RLIMIT_AS, &less);
      load();
    });
  } catch (const CrashedCopy& error) {
    throw RuntimeFault(cannot + error.what());
  } catch (const InterruptedCopy&) {
    throw;
  } catch (const Error& error) {
    if (error.exitCode() != ExitCode::kRuntimeFault) {
      throw;
    }
    throw RuntimeFault(cannot + error.what());
  }
  return load();
}

ChosenPolicy chooseNetwork(const PolicyChoice& choice, const fs::path& shipped, const std::function<bool()>& stop) {
  const auto untrained = [&](const std::string& warning) {
    return withinMemory("the untrained policy", stop,
                        [&] { return networkPolicies().untrained(choice.untrained_seed, warning); });
  };
  if (choice.policy == kUntrainedPolicy) {
    return untrained("");
  }
  const bool is_shipped = choice.policy == kShippedPolicy;
  const fs::path file = is_shipped ? shipped : fs::path(choice.policy);
  std::error_code ignored;
  const bool missing = !file.empty() && fs::status(file, ignored).type() == fs::file_type::not_found;
  if (!missing) {
    return withinMemory("policy " + file.string(), stop, [&] { return trained(file, choice.policy, stop); });
  }
  if (is_shipped ? choice.require_policy : !choice.allow_untrained) {
    throw InvalidInput("policy " + file.string() + ": must be a readable file, but is not there");
  }
  // The course's guard, the one place where a measurement goes on with something else than was asked for.
  return untrained("policy " + file.string() +
                   ": there is no such file. Running an UNTRAINED policy instead: success and transfer say nothing "
                   "until a trained one is named.");
}

}  // namespace

bool isWithoutFile(const std::string& policy) {
  return policy == kExpertPolicy || policy == kPlannerPolicy || policy == kUntrainedPolicy;
}

ChosenPolicy choosePolicy(const PolicyChoice& choice, const fs::path& shipped, const std::function<bool()>& stop) {
  const Task& task = choice.task;
  if (choice.policy == kExpertPolicy) {
    return {[&task] { return std::make_unique<ScriptedExpert>(task); },
            kExpertPolicy,
            {{"scripted", kExpertPolicy}},
            {{"runs_on", "scripted"}},
            {},
            ""};
  }
  if (choice.policy == kPlannerPolicy) {
    return planner(task);
  }
  ChosenPolicy chosen = chooseNetwork(choice, shipped, stop);
  if (!chosen.interface.fits(task)) {
    throw InvalidInput("policy " + choice.policy + ": has the interface " + chosen.interface.text() +
                       "; must have one of the task " + task.name + ": " + joined(policyInterfacesOf(task)) +
                       "; or be " + kExpertPolicy + " or " + kPlannerPolicy);
  }
  return chosen;
}

}  // namespace pusht
