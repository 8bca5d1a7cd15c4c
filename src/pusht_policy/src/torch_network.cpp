// SPDX-License-Identifier: BSD-3-Clause
#include "torch_network.hpp"

#include <ATen/Version.h>
#include <dlfcn.h>
#include <torch/csrc/jit/passes/constant_propagation.h>
#include <torch/csrc/jit/passes/peephole.h>
#include <torch/csrc/jit/runtime/graph_executor.h>
#include <torch/nn/modules/linear.h>
#include <torch/script.h>
#include <torch/version.h>

#include <algorithm>
#include <filesystem>
#include <new>
#include <optional>
#include <sstream>
#include <utility>

#include "pusht_policy/network_policy.hpp"
#include "pusht_task/error.hpp"

namespace pusht {
namespace {

constexpr int kActionColumns = std::tuple_size<Action>::value;

torch::jit::Module loadModule(const std::string& bytes, const std::string& name) {
  try {
    std::istringstream stream(bytes);
    torch::jit::Module module = torch::jit::load(stream, torch::kCPU);
    module.eval();
    restoreTracedNumbers(module);
    return module;
  } catch (const std::exception& error) {
    throw InvalidInput(name + ": must be TorchScript: " + firstLine(error));
  }
}

template <class NamedTensors>
void requireFinite(const NamedTensors& tensors, const std::string& name) {
  for (const auto& tensor : tensors) {
    bool finite = false;
    try {
      finite = torch::isfinite(tensor.value).all().template item<bool>();
    } catch (const std::exception& error) {  // sparse and quantized tensors cannot be asked
      throw BadDependency(name + ": " + tensor.name + " must be a plain tensor: " + firstLine(error));
    }
    if (!finite) {
      throw BadDependency(name + ": " + tensor.name + " must be finite");
    }
  }
}

/// A value's types and sizes: "float [1, 2]", "Tuple (float [1, 8, 2], float [1, 64])".
std::string describe(const torch::jit::IValue& value) {
  std::ostringstream text;
  if (value.isTensor()) {
    text << value.toTensor().dtype().name() << ' ' << value.toTensor().sizes();
    return text.str();
  }
  text << value.tagKind();
  if (value.isTuple()) {
    const char* separator = " (";
    for (const torch::jit::IValue& element : value.toTupleRef().elements()) {
      text << std::exchange(separator, ", ") << describe(element);
    }
    text << ')';
  }
  return text.str();
}

/// Sizes of a tensor of one rollout.
std::vector<std::int64_t> batchOfOne(const PolicyDescription::Shape& shape) {
  std::vector<std::int64_t> sizes = {1};
  sizes.insert(sizes.end(), shape.begin(), shape.end());
  return sizes;
}

torch::Tensor tensorOf(Span<const float> values, const std::vector<std::int64_t>& sizes) {
  torch::Tensor tensor = torch::empty(sizes);
  std::copy(values.begin(), values.end(), tensor.data_ptr<float>());
  return tensor;
}

}  // namespace

std::string firstLine(const std::exception& error) {
  const auto* torch_error = dynamic_cast<const c10::Error*>(&error);
  std::string message = torch_error != nullptr ? torch_error->what_without_backtrace() : error.what();
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
      message.find("can't allocate memory") != std::string::npos) {
    throw std::bad_alloc();
  }
  constexpr std::string_view kMark = "RuntimeError: ";
  if (const auto mark = message.rfind(kMark); mark != std::string::npos) {
    message.erase(0, mark + kMark.size());
  }
  message.erase(0, message.find_first_not_of('\n'));
  message.erase(std::min(message.find('\n'), message.size()));
  std::replace_if(
      message.begin(), message.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return message;
}

TorchNetwork::TorchNetwork(const std::string& bytes, std::string name, PolicyDescription description)
    : name_(std::move(name)),
      description_(std::move(description)),
      observation_sizes_(description_.described
                             ? batchOfOne({description_.observations, description_.interface.numbers()})
                             : batchOfOne({description_.interface.numbers()})),
      action_sizes_(description_.described ? batchOfOne({description_.actions, kActionColumns})
                                           : batchOfOne({kActionColumns})),
      module_(std::make_shared<torch::jit::Module>(loadModule(bytes, name_))) {
  torch::set_num_threads(1);
  requireFinite(module_->named_parameters(), name_);
  requireFinite(module_->named_buffers(), name_);
}

std::vector<Sizes> TorchNetwork::inputSizes() const {
  std::vector<Sizes> sizes = {observation_sizes_};
  for (const PolicyDescription::Shape& shape : {description_.state, description_.noise}) {
    if (!shape.empty()) {
      sizes.push_back(batchOfOne(shape));
    }
  }
  return sizes;
}

void TorchNetwork::answer(Span<const NetworkCall> calls) {
  for (const NetworkCall& call : calls) {
    run(call.observations, call.state, call.noise, call.actions);
  }
}

void TorchNetwork::run(Span<const float> observations, Span<float> state, Span<const float> noise,
                       Span<float> actions) {
  const torch::NoGradGuard no_gradients;
  const torch::jit::GraphOptimizerEnabledGuard as_written(false);  // the thousandth call computes as the first
  std::vector<torch::jit::IValue> inputs = {tensorOf(observations, observation_sizes_)};
  if (!state.empty()) {
    inputs.emplace_back(tensorOf(state, batchOfOne(description_.state)));
  }
  if (!noise.empty()) {
    inputs.emplace_back(tensorOf(noise, batchOfOne(description_.noise)));
  }
  torch::jit::IValue result;
  try {
    result = module_->forward(std::move(inputs));
  } catch (const std::exception& error) {
    refuse(", but fails: " + firstLine(error));
  }
  if (state.empty()) {
    return take(result, action_sizes_, actions, result);
  }
  if (!result.isTuple() || result.toTupleRef().elements().size() != 2) {
    refuse(", not to " + describe(result));
  }
  take(result.toTupleRef().elements()[0], action_sizes_, actions, result);
  take(result.toTupleRef().elements()[1], batchOfOne(description_.state), state, result);
}

void TorchNetwork::refuse(const std::string& instead) const {
  throw BadDependency(name_ + ": must map " + description_.inputs() + " to " + description_.outputs() +
                      (description_.described ? ", as its " + std::string(kDescriptionFile) + " says" : "") + instead);
}

/// Copies a part of the result.
void TorchNetwork::take(const torch::jit::IValue& part, const std::vector<std::int64_t>& sizes, Span<float> values,
                        const torch::jit::IValue& result) const {
  if (!part.isTensor() || part.toTensor().scalar_type() != torch::kFloat32 || part.toTensor().sizes() != sizes) {
    refuse(", not to " + describe(result));
  }
  const torch::Tensor whole = part.toTensor().contiguous();
  std::copy_n(whole.data_ptr<float>(), values.size(), values.begin());
}

std::shared_ptr<torch::jit::Graph> TorchNetwork::straightened() const {
  constexpr bool kOptimizeNumerics = false;
  try {
    const torch::jit::Module frozen = torch::jit::freeze(*module_, c10::nullopt, kOptimizeNumerics);
    std::shared_ptr<torch::jit::Graph> graph = frozen.get_method("forward").graph();
    const std::vector<Sizes> sizes = inputSizes();
    if (graph->inputs().size() == 1 + sizes.size()) {  // with the shapes known, no branch depends on them
      for (std::size_t i = 0; i < sizes.size(); ++i) {
        graph->inputs()[1 + i]->setType(c10::TensorType::create(torch::empty(sizes[i])));
      }
      torch::jit::PeepholeOptimize(graph);
      torch::jit::ConstantPropagation(graph);
    }
    return graph;
  } catch (const std::exception& error) {
    throw UnfitForKernel("cannot be frozen: " + firstLine(error));
  }
}

std::vector<Operation> untrainedOperations(std::uint64_t seed) {
  constexpr int kHidden = 64;
  const std::vector<int> widths = {PolicyInterface().numbers(), kHidden, kHidden, kActionColumns};
  using Kind = Operation::Kind;
  torch::manual_seed(seed);
  std::vector<Operation> operations;
  for (std::size_t i = 1; i < widths.size(); ++i) {
    const torch::nn::Linear layer(widths[i - 1], widths[i]);
    operations.push_back({Kind::kMatrix, widths[i], toVector(layer->weight.detach().t())});
    operations.push_back({Kind::kAdd, widths[i], toVector(layer->bias.detach())});
    const bool is_last = i + 1 == widths.size();
    operations.push_back(is_last ? Operation{Kind::kTanh, widths[i], {}}
                                 : Operation{Kind::kMax, widths[i], std::vector<float>(widths[i], 0.0F)});
  }
  return operations;
}

std::string libtorchVersion() { return TORCH_VERSION; }

namespace {

/// Result of a function of a library that may not be loaded.
template <class Result>
std::optional<Result> ask(const char* function) {
  void* const address = dlsym(RTLD_DEFAULT, function);
  return address == nullptr ? std::nullopt : std::optional<Result>(reinterpret_cast<Result (*)()>(address)());
}

}  // namespace

std::map<std::string, std::string> libtorchChoices() {
  std::map<std::string, std::string> choices;
  if (const auto core = ask<const char*>("openblas_get_corename")) {
    choices["openblas_core"] = *core;
  }
  if (const auto threads = ask<int>("openblas_get_num_threads")) {
    choices["openblas_threads"] = std::to_string(*threads);
  }
  if (const auto vectors = ask<int>("dnnl_get_effective_cpu_isa")) {
    choices["onednn_isa"] = std::to_string(*vectors);
  }
  constexpr std::string_view kMark = "CPU capability usage: ";
  const std::string configuration = at::show_config();
  if (const auto mark = configuration.find(kMark); mark != std::string::npos) {
    const std::size_t first = mark + kMark.size();
    choices["libtorch_vectors"] = configuration.substr(first, configuration.find('\n', first) - first);
  }
  return choices;
}

std::string activeBlas() {
  Dl_info library{};
  void* const sgemm = dlsym(RTLD_DEFAULT, "sgemm_");
  if (sgemm == nullptr || dladdr(sgemm, &library) == 0) {
    return "";
  }
  std::error_code error;
  return std::filesystem::canonical(library.dli_fname, error).string();
}

}  // namespace pusht
