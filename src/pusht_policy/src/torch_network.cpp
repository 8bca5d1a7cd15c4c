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

constexpr int kColumns = std::tuple_size<Observation>::value;

torch::jit::Module loadModule(const std::string& bytes, const std::string& name) {
  try {
    std::istringstream stream(bytes);
    torch::jit::Module module = torch::jit::load(stream, torch::kCPU);
    module.eval();
    return module;
  } catch (const std::exception& error) {
    throw InvalidInput(name + ": must be TorchScript: " + firstLine(error));
  }
}

/// Graph of forward() for one row, with operations and constants alone. No pass that is applied here changes the
/// order of floating-point operations.
std::shared_ptr<torch::jit::Graph> straightened(const torch::jit::Module& module) {
  constexpr bool kOptimizeNumerics = false;
  const torch::jit::Module frozen = torch::jit::freeze(module, c10::nullopt, kOptimizeNumerics);
  std::shared_ptr<torch::jit::Graph> graph = frozen.get_method("forward").graph();
  if (graph->inputs().size() == 2) {  // with the shape of the row known, no branch depends on it
    graph->inputs()[1]->setType(c10::TensorType::create(torch::empty({1, kColumns})));
    torch::jit::PeepholeOptimize(graph);
    torch::jit::ConstantPropagation(graph);
  }
  return graph;
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

std::string describe(const torch::jit::IValue& value) {
  std::ostringstream text;
  if (value.isTensor()) {
    text << value.toTensor().dtype().name() << ' ' << value.toTensor().sizes();
  } else {
    text << value.tagKind();
  }
  return text.str();
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

TorchNetwork::TorchNetwork(const std::string& bytes, std::string name)
    : name_(std::move(name)), module_(std::make_shared<torch::jit::Module>(loadModule(bytes, name_))) {
  torch::set_num_threads(1);
  requireFinite(module_->named_parameters(), name_);
  requireFinite(module_->named_buffers(), name_);
}

Action TorchNetwork::act(const Observation& observation) {
  const torch::NoGradGuard no_gradients;
  const torch::jit::GraphOptimizerEnabledGuard as_written(false);  // the thousandth call computes as the first
  const torch::Tensor row = torch::empty({1, kColumns});
  std::copy(observation.begin(), observation.end(), row.data_ptr<float>());
  torch::jit::IValue result;
  try {
    result = module_->forward({row});
  } catch (const std::exception& error) {
    throw BadDependency(name_ + ": must map float [1, 10] to float [1, 2], but fails: " + firstLine(error));
  }
  Action action{};
  const auto columns = static_cast<std::int64_t>(action.size());
  if (!result.isTensor() || result.toTensor().scalar_type() != torch::kFloat32 ||
      result.toTensor().sizes() != torch::IntArrayRef({1, columns})) {
    throw BadDependency(name_ + ": must map float [1, 10] to float [1, 2], not to " + describe(result));
  }
  const torch::Tensor values = result.toTensor().contiguous();
  std::copy_n(values.data_ptr<float>(), action.size(), action.begin());
  return action;
}

std::vector<Operation> TorchNetwork::operations() const {
  try {
    return readGraph(*straightened(*module_), kColumns);
  } catch (const UnfitForKernel&) {
    throw;
  } catch (const std::exception& error) {
    throw UnfitForKernel("cannot be frozen: " + firstLine(error));
  }
}

std::vector<Operation> untrainedOperations(std::uint64_t seed) {
  constexpr int kHidden = 64;
  const std::vector<int> widths = {kColumns, kHidden, kHidden, std::tuple_size<Action>::value};
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
