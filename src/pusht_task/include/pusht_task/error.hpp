// SPDX-License-Identifier: BSD-3-Clause
/// Errors of the suite. The kind of an error is also the exit code of the process.
#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

namespace pusht {

/// Exit codes of commands and nodes, also in replies of services.
enum class ExitCode {
  kOk = 0,
  kInvalidInput = 2,    ///< bad input or configuration
  kBadDependency = 3,   ///< something the run needs is missing or not as expected
  kRuntimeFault = 4,    ///< a peer died, a deadline passed, the disk is full, the run was interrupted
  kContractError = 5,   ///< an audit found an error of the contract
  kNotMet = 6,          ///< a requirement (--require) is shown not to be met
  kUndecided = 7,       ///< the episodes cannot say whether a requirement is met
  kInternalError = 70,  ///< a defect of ours or of a library
};

/// An error with a message of one line that names the thing, its value and the rule it breaks.
class Error : public std::exception {
 public:
  Error(ExitCode exit_code, std::string message) : exit_code_(exit_code), message_(std::move(message)) {}
  ExitCode exitCode() const { return exit_code_; }
  const char* what() const noexcept override { return message_.c_str(); }

  /// Puts `context` in front of the message, before the error is rethrown: "row 3: ...".
  void addContext(const std::string& context) { message_ = context + ": " + message_; }

 private:
  ExitCode exit_code_;
  std::string message_;
};

/// Bad input or configuration: exit code 2.
struct InvalidInput : Error {
  explicit InvalidInput(const std::string& message) : Error(ExitCode::kInvalidInput, message) {}
};
/// Missing or unexpected dependency of the run: exit code 3.
struct BadDependency : Error {
  explicit BadDependency(const std::string& message) : Error(ExitCode::kBadDependency, message) {}
};
/// Fault while running: exit code 4.
struct RuntimeFault : Error {
  explicit RuntimeFault(const std::string& message) : Error(ExitCode::kRuntimeFault, message) {}
};
/// Failure of a world's physics; other parameters may succeed.
struct SimulationFault : RuntimeFault {
  using RuntimeFault::RuntimeFault;
};
/// Broken contract of a simulator, found by an audit: exit code 5.
struct ContractError : Error {
  explicit ContractError(const std::string& message) : Error(ExitCode::kContractError, message) {}
};
/// Defect of the suite or of a library: exit code 70.
struct InternalError : Error {
  explicit InternalError(const std::string& message) : Error(ExitCode::kInternalError, message) {}
};

/// Calls call() and turns its std::domain_error, which libraries without Error throw, into InvalidInput.
template <class Call>
decltype(auto) asInput(const Call& call) {
  try {
    return call();
  } catch (const std::domain_error& refusal) {
    throw InvalidInput(refusal.what());
  }
}

/// Exit code of any failure. Used-up memory is a runtime fault, std::domain_error is bad input, and any other exception
/// that is no Error is a defect.
inline ExitCode exitCodeOf(const std::exception& failure) {
  if (dynamic_cast<const std::bad_alloc*>(&failure) != nullptr) {
    return ExitCode::kRuntimeFault;
  }
  if (dynamic_cast<const std::domain_error*>(&failure) != nullptr) {
    return ExitCode::kInvalidInput;
  }
  const auto* error = dynamic_cast<const Error*>(&failure);
  return error == nullptr ? ExitCode::kInternalError : error->exitCode();
}

}  // namespace pusht
