// SPDX-License-Identifier: BSD-3-Clause
#include "onnx_policy.hpp"

#include <algorithm>
#include <limits>
#include <system_error>
#include <tuple>
#include <utility>

#include "checkpoint_provenance.hpp"
#include "network_probes.hpp"
#include "onnx_graph.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/task.hpp"

namespace pusht {
namespace {

constexpr int kOnnxInputs = std::tuple_size<Observation>::value;
constexpr int kOnnxOutputs = std::tuple_size<Action>::value;

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

/// Throws BadDependency if an action for a probe is not finite.
void requireFiniteActions(OnnxPolicy& policy) {
  std::vector<Policy::Query> queries;
  for (const Observation& probe : networkProbes()) {
    queries.push_back({probe, nullptr});
  }
  std::vector<Action> actions(queries.size());
  policy.act(queries, actions);
  const auto bad = std::find_if(actions.begin(), actions.end(), [](const Action& action) { return !isFinite(action); });
  if (bad != actions.end()) {
    throw BadDependency("its actions must be finite, but are not for probe " +
                        std::to_string(std::distance(actions.begin(), bad)));
  }
}

}  // namespace

OnnxPolicy::OnnxPolicy(OnnxInfo info, NetworkKernel kernel) : info_(std::move(info)), kernel_(std::move(kernel)) {
  info_.operations = kernel_.operations();
  info_.instruction_set = toString(kernel_.instructionSet());
}

std::unique_ptr<OnnxPolicy> OnnxPolicy::load(const std::filesystem::path& path, InstructionSet instruction_set) {
  const std::string name = "policy " + path.string();
  const std::string bytes = readOnnxFile(path, name);
  OnnxInfo info;
  info.sha256 = sha256(bytes);
  requireHashOfProvenance(path, name, info.sha256);
  try {
    const OnnxNetwork network = readOnnx(bytes, kOnnxInputs, kOnnxOutputs);
    info.opset = network.opset;
    info.producer = network.producer;
    std::unique_ptr<OnnxPolicy> policy(
        new OnnxPolicy(std::move(info), NetworkKernel(kOnnxInputs, network.operations, instruction_set)));
    requireFiniteActions(*policy);
    return policy;
  } catch (Error& error) {
    error.addContext(name);
    throw;
  }
}

std::unique_ptr<OnnxPolicy> OnnxPolicy::clone() const {
  return std::unique_ptr<OnnxPolicy>(new OnnxPolicy(info_, kernel_));
}

void OnnxPolicy::act(Span<const Query> queries, Span<Action> actions) {
  inputs_.resize(queries.size() * kOnnxInputs);
  outputs_.resize(queries.size() * kOnnxOutputs);
  for (std::size_t i = 0; i < queries.size(); ++i) {
    std::copy_n(queries[i].observation.begin(), kOnnxInputs, inputs_.data() + i * kOnnxInputs);
  }
  kernel_.run(inputs_, outputs_);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    std::copy_n(outputs_.data() + i * kOnnxOutputs, kOnnxOutputs, actions[i].begin());
  }
}

}  // namespace pusht
