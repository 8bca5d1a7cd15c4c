// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/network_policy.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "pusht_policy/checkpoint_home.hpp"
#include "pusht_policy/formats.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"
#include "rehearsal.hpp"
#include "torch_network.hpp"

namespace pusht {
namespace {

constexpr int kInputs = std::tuple_size<Observation>::value;
constexpr int kOutputs = std::tuple_size<Action>::value;

constexpr int kSpawnProbes = 48;
constexpr int kWideProbes = 16;
constexpr double kWideRange = 2.0;   // every number of a wide probe lies in +- this
constexpr float kAgreement = 1e-5F;  // between kernel and libtorch; relative where actions exceed 1

/// Observations with which a network is tried out: starts of episodes, and some that no episode shows.
std::vector<Observation> probes() {
  std::vector<Observation> probes(kSpawnProbes + kWideProbes);
  for (int i = 0; i < kSpawnProbes; ++i) {
    probes[i] = observe(spawn(i));
  }
  NumpyGenerator generator(kSpawnProbes);
  for (int i = kSpawnProbes; i < kSpawnProbes + kWideProbes; ++i) {
    std::generate(probes[i].begin(), probes[i].end(), [&] { return generator.uniform(-kWideRange, kWideRange); });
  }
  return probes;
}

/// Outputs of the network for the probes. Throws BadDependency if one is not finite.
std::vector<Action> tryOut(TorchNetwork& network, const std::string& name) {
  std::vector<Action> actions;
  for (const Observation& probe : probes()) {
    actions.push_back(network.act(probe));
    if (!isFinite(actions.back())) {
      throw BadDependency(name + ": its actions must be finite, but are not for probe " +
                          std::to_string(actions.size() - 1));
    }
  }
  return actions;
}

/// If a file PATH.provenance.json says which bytes the checkpoint must have, these are they.
void requireProvenance(const std::filesystem::path& path, const std::string& name, const std::string& sha256) {
  const std::filesystem::path provenance = provenancePath(path);
  std::error_code error;
  const auto type = std::filesystem::symlink_status(provenance, error).type();
  if (type == std::filesystem::file_type::not_found || error == std::errc::filename_too_long) {
    return;
  }
  const std::string text = readFile(provenance, "provenance");
  nlohmann::json format = kProvenanceFormat;
  std::string expected;
  try {
    const nlohmann::json content = nlohmann::json::parse(text);
    format = content.value("format", format);
    expected = content.at("checkpoint").at("sha256").get<std::string>();
  } catch (const nlohmann::json::exception&) {
    expected.clear();
  }
  if (format != kProvenanceFormat) {
    throw InvalidInput("provenance " + provenance.string() + ": format is " + format.dump() + ", must be " +
                       std::to_string(kProvenanceFormat) + "; another version of the suite wrote it");
  }
  if (expected.size() != sha256.size() || expected.find_first_not_of("0123456789abcdef") != std::string::npos) {
    throw InvalidInput("provenance " + provenance.string() + ": must be JSON with a checkpoint.sha256 of " +
                       std::to_string(sha256.size()) + " hex digits");
  }
  if (sha256 != expected) {
    throw BadDependency(name + ": its SHA-256 is " + sha256 + ", must be " + expected + " (" + provenance.string() +
                        ")");
  }
}

/// A checkpoint's bytes, verified as far as that goes without libtorch. Throws as NetworkPolicy::load() does.
struct CheckpointFile {
  explicit CheckpointFile(const std::filesystem::path& path)
      : name("policy " + path.string()), bytes(readFile(path, "policy")), hash(sha256(bytes)) {
    requireProvenance(path, name, hash);
    records = verifiedRecords(bytes, name);
  }

  std::string name;  // for messages
  std::string bytes;
  std::string hash;
  Records records;
};

/// A network that has been loaded and tried out. Throws as NetworkPolicy::load() does.
struct Checkpoint {
  explicit Checkpoint(const CheckpointFile& file) : network(std::make_unique<TorchNetwork>(file.bytes, file.name)) {
    actions = tryOut(*network, file.name);
    if (tryOut(*network, file.name) != actions) {
      throw BadDependency(file.name + ": must act the same on the same observation, but has a memory or is random");
    }
  }

  std::unique_ptr<TorchNetwork> network;
  std::vector<Action> actions;  // on the probes
};

/// Loads the checkpoint at `path` in a copy of the process first: what libtorch makes of damaged files, or of code that
/// never returns, ends there.
template <class Load>
auto loadRehearsed(const std::filesystem::path& path, std::chrono::milliseconds deadline,
                   const std::function<bool()>& stop, Load load) {
  const CheckpointFile file(path);
  rehearse(file.name, deadline, stop, [&] {
    requireWholeTensors(file.bytes, file.records, file.name);
    load(file);
  });
  return load(file);
}

/// Throws UnfitForKernel unless the kernel does to the probes what libtorch did.
void requireAgreement(NetworkKernel& kernel, const std::vector<Action>& expected) {
  const std::vector<Observation> inputs = probes();
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    Action action{};
    kernel.run(inputs[i], action);
    for (std::size_t axis = 0; axis < action.size(); ++axis) {
      const float difference = std::abs(action[axis] - expected[i][axis]);
      if (!(difference <= kAgreement * std::max(1.0F, std::abs(expected[i][axis])))) {
        throw UnfitForKernel("the kernel differs from libtorch by " + std::to_string(difference) + " for probe " +
                             std::to_string(i));
      }
    }
  }
}

}  // namespace

NetworkPolicy::NetworkPolicy(std::string sha256, std::unique_ptr<NetworkKernel> kernel) : kernel_(std::move(kernel)) {
  info_.sha256 = std::move(sha256);
  info_.operations = kernel_->operations();
  info_.instruction_set = toString(kernel_->instructionSet());
}

NetworkPolicy::NetworkPolicy(std::string sha256, std::unique_ptr<TorchNetwork> network, std::string why_not_on_kernel)
    : network_(std::move(network)) {
  info_.sha256 = std::move(sha256);
  info_.why_not_on_kernel = std::move(why_not_on_kernel);
}

NetworkPolicy::NetworkPolicy(NetworkInfo info, std::unique_ptr<NetworkKernel> kernel,
                             std::unique_ptr<TorchNetwork> network)
    : info_(std::move(info)), kernel_(std::move(kernel)), network_(std::move(network)) {}

NetworkPolicy::~NetworkPolicy() = default;

std::unique_ptr<NetworkPolicy> NetworkPolicy::clone() const {
  return std::unique_ptr<NetworkPolicy>(
      new NetworkPolicy(info_, kernel_ != nullptr ? std::make_unique<NetworkKernel>(*kernel_) : nullptr,
                        network_ != nullptr ? std::make_unique<TorchNetwork>(*network_) : nullptr));
}

std::unique_ptr<NetworkPolicy> NetworkPolicy::load(const std::filesystem::path& path, InstructionSet instruction_set,
                                                   std::chrono::milliseconds deadline,
                                                   const std::function<bool()>& stop) {
  return loadRehearsed(path, deadline, stop, [&](const CheckpointFile& file) {
    Checkpoint checkpoint(file);
    try {
      auto kernel = std::make_unique<NetworkKernel>(kInputs, checkpoint.network->operations(), instruction_set);
      requireAgreement(*kernel, checkpoint.actions);
      return std::unique_ptr<NetworkPolicy>(new NetworkPolicy(file.hash, std::move(kernel)));
    } catch (const UnfitForKernel& error) {
      return std::unique_ptr<NetworkPolicy>(new NetworkPolicy(file.hash, std::move(checkpoint.network), error.what()));
    }
  });
}

std::unique_ptr<NetworkPolicy> NetworkPolicy::loadOnLibtorch(const std::filesystem::path& path) {
  const auto never = [] { return false; };
  return loadRehearsed(path, kLoadDeadline, never, [](const CheckpointFile& file) {
    return std::unique_ptr<NetworkPolicy>(
        new NetworkPolicy(file.hash, std::move(Checkpoint(file).network), "asked for on libtorch"));
  });
}

std::unique_ptr<NetworkPolicy> NetworkPolicy::untrained(std::uint64_t seed) {
  auto kernel = std::make_unique<NetworkKernel>(kInputs, untrainedOperations(seed));
  return std::unique_ptr<NetworkPolicy>(new NetworkPolicy("", std::move(kernel)));
}

void NetworkPolicy::act(Span<const Query> queries, Span<Action> actions) {
  if (kernel_ != nullptr) {
    return actOnKernel(queries, actions);
  }
  std::transform(queries.begin(), queries.end(), actions.begin(),
                 [&](const Query& query) { return network_->act(query.observation); });
}

void NetworkPolicy::actOnKernel(Span<const Query> queries, Span<Action> actions) {
  inputs_.resize(queries.size() * kInputs);
  outputs_.resize(queries.size() * kOutputs);
  for (std::size_t i = 0; i < queries.size(); ++i) {
    std::copy_n(queries[i].observation.begin(), kInputs, inputs_.data() + i * kInputs);
  }
  kernel_->run(inputs_, outputs_);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    std::copy_n(outputs_.data() + i * kOutputs, kOutputs, actions[i].begin());
  }
}

}  // namespace pusht
