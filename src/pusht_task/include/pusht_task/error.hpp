// SPDX-License-Identifier: BSD-3-Clause
/// The ways in which the suite fails. What an error means to a caller is its exit code.
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
  kInternalError = 70,  ///< a defect of ours or of a library
};

/// An error with a message of one line that names the thing, its value and the rule it breaks.
class Error : public std::exception {
 public:
  Error(ExitCode exit_code, std::string message) : exit_code_(exit_code), message_(std::move(message)) {}
  ExitCode exitCode() const { return exit_code_; }
  const char* what() const noexcept override { return message_.c_str(); }

  /// Says in front of the message where the error came up; for whoever catches and rethrows it.
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
/// The physics of a world failed, so with other parameters it may do better.
struct SimulationFault : RuntimeFault {
  using RuntimeFault::RuntimeFault;
};
/// Defect of the suite or of a library: exit code 70.
struct InternalError : Error {
  explicit InternalError(const std::string& message) : Error(ExitCode::kInternalError, message) {}
};

/// Calls call(); what that refuses as std::domain_error, as libraries do that know no Error, is bad input.
template <class Call>
decltype(auto) asInput(const Call& call) {
  try {
    return call();
  } catch (const std::domain_error& refusal) {
    throw InvalidInput(refusal.what());
  }
}

/// What any failure means to a caller; one that is no Error is a defect, but for memory that is used up and for what is
/// outside the domain of a function.
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
