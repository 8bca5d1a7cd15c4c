// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include "network_choice.hpp"
#include "onnx_policy.hpp"

namespace pusht {
namespace {

/// Its identity has no library: the kernel has equal bits everywhere.
ChosenPolicy trainedOnnx(const std::filesystem::path& path, const std::string& name) {
  const std::shared_ptr<const OnnxPolicy> policy = OnnxPolicy::load(path);
  const OnnxInfo& info = policy->info();
  ChosenPolicy chosen;
  chosen.make = [policy] { return policy->clone(); };
  chosen.name = name;
  chosen.identity = {{"sha256", info.sha256}, {"operations", info.operations}};
  chosen.provenance = {{"sha256", info.sha256},
                       {"runs_on", "fixed-order kernel"},
                       {"operations", info.operations},
                       {"instruction_set", info.instruction_set},
                       {"onnx", {{"opset", info.opset}, {"producer", info.producer}}}};
  if (!info.data_files.empty()) {
    chosen.identity["data_files"] = chosen.provenance["data_files"] = info.data_files;
  }
  addDescription(info.description, chosen.identity);
  addDescription(info.description, chosen.provenance);
  addNoise(info.description, chosen.provenance);
  chosen.libraries = {kOnnxPolicyLibrary};
  return chosen;
}

}  // namespace
}  // namespace pusht

extern "C" const pusht::OnnxPolicies kOnnxPolicies = {pusht::trainedOnnx};
