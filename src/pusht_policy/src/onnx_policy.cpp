// SPDX-License-Identifier: BSD-3-Clause
#include "onnx_policy.hpp"

#include <limits>
#include <system_error>
#include <utility>

#include "checkpoint_provenance.hpp"
#include "network_trial.hpp"
#include "onnx_graph.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"

namespace pusht {
namespace {

/// Bytes of the file. Its size is asked first: protobuf reads no more, and a network of the kernel needs far less.
std::string readOnnxFile(const std::filesystem::path& path, const std::string& name) {
  constexpr std::uintmax_t kMostBytes = std::numeric_limits<std::int32_t>::max();
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!error && size > kMostBytes) {
    throw InvalidInput(name + ": must have at most " + std::to_string(kMostBytes) + " bytes, as ONNX has, but has " +
                       std::to_string(size));
  }
  return readFile(path, "policy");
}

}  // namespace

std::unique_ptr<OnnxPolicy> OnnxPolicy::load(const std::filesystem::path& path, InstructionSet instruction_set) {
  const std::string name = "policy " + path.string();
  const std::string bytes = readOnnxFile(path, name);
  requireHashOfProvenance(path, name, sha256(bytes));
  return read(bytes, path.has_parent_path() ? path.parent_path() : ".", name, instruction_set);
}

std::unique_ptr<OnnxPolicy> OnnxPolicy::read(const std::string& bytes, const std::filesystem::path& folder,
                                             const std::string& name, InstructionSet instruction_set) {
  OnnxInfo info;
  info.sha256 = sha256(bytes);
  OnnxNetwork network;
  try {
    network = readOnnx(bytes, folder);
  } catch (Error& error) {
    error.addContext(name);
    throw;
  }
  const PolicyDescription& description = network.description;
  const std::size_t columns =
      observationNumbers(description) + numbersIn(description.state) + numbersIn(description.noise);
  const NetworkKernel kernel(static_cast<int>(columns), network.operations, instruction_set);
  auto on_kernel = std::make_unique<KernelNetwork>(kernel);
  answersToProbes(*on_kernel, description, name);
  info.operations = kernel.operations();
  info.instruction_set = toString(kernel.instructionSet());
  info.opset = network.opset;
  info.producer = network.producer;
  info.data_files = network.data_files;
  info.description = description;
  return std::unique_ptr<OnnxPolicy>(
      new OnnxPolicy(std::move(info), std::make_unique<NetworkActor>(std::move(on_kernel), description)));
}

std::unique_ptr<OnnxPolicy> OnnxPolicy::clone() const {
  return std::unique_ptr<OnnxPolicy>(new OnnxPolicy(info_, actor_->clone()));
}

}  // namespace pusht
