// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>
#include <cstdio>
#include <memory>

#include "network_choice.hpp"
#include "onnx_policy.hpp"
#include "pusht_task/error.hpp"

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
  chosen.interface = info.description.interface;
  chosen.libraries = {kOnnxPolicyLibrary};
  return chosen;
}

}  // namespace
}  // namespace pusht

extern "C" const pusht::OnnxPolicies kOnnxPolicies = {pusht::trainedOnnx};

/// Whether `compare` takes the ONNX file of these bytes, for programs in Python: 0, or the exit code and the reason in
/// `reason`, which has room for `room` bytes.
extern "C" int checkOnnx(const char* bytes, std::size_t size, char* reason, std::size_t room) {
  try {
    pusht::OnnxPolicy::read({bytes, size}, {}, "ONNX");
    return 0;
  } catch (const pusht::Error& error) {
    std::snprintf(reason, room, "%s", error.what());
    return static_cast<int>(error.exitCode());
  }
}
