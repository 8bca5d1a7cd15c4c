// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/setup.hpp"

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_task/ros/installed_file.hpp"
#include "sim2sim_eval/command_line.hpp"
#include "sim2sim_eval/provenance.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEngineLibrary = "libpusht_engine.so";

/// Those that compute the results, besides what a policy on libtorch takes; all but the engine's compute a rollout of
/// the reference.
const std::vector<std::string> kLibraries = {"libm.so",          "libmujoco.so",       "libpusht_mujoco.so",
                                             "libpusht_task.so", "libpusht_policy.so", "libsim2sim_eval.so",
                                             kEngineLibrary};

std::shared_ptr<const pusht::MujocoScene> loadScene(const std::string& file) {
  return std::make_shared<const pusht::MujocoScene>(
      file.empty() ? pusht::installedFile("pusht_mujoco", "scenes/pusht.xml") : fs::path(file));
}

}  // namespace

void describeSimulators(RunConfiguration& configuration, const pusht::TwoMassParameters& knobs) {
  configuration.reference = "mujoco";
  configuration.engine = "two_mass";
  configuration.knobs = nlohmann::ordered_json::object();
  for (const pusht::two_mass::Knob& knob : pusht::two_mass::kKnobs) {
    configuration.knobs[knob.name] = knobs.*knob.value;
  }
}

Setup::Setup(const pusht::PolicyChoice& policy, const std::string& scene)
    : scene_(loadScene(scene)),
      policy_(pusht::choosePolicy(policy, pusht::installedFile("pusht_policy", "policies/bc_policy.ts.pt"))),
      code_(codeFingerprint(kLibraries, policy_.libraries)) {
  warn(policy_.warning);
}

Players Setup::players(const pusht::TwoMassParameters& knobs) const {
  const auto make_worlds = [scene = scene_, knobs](int lanes) {
    std::vector<std::unique_ptr<pusht::Simulator>> references(lanes);
    std::generate(references.begin(), references.end(), [&] { return std::make_unique<pusht::MujocoWorld>(scene); });
    return Worlds{std::make_unique<pusht::SimulatorLanes>(std::move(references)),
                  std::make_unique<pusht::TwoMassLanes>(lanes, knobs),
                  std::make_unique<pusht::TwoMassLanes>(lanes, knobs)};
  };
  return {make_worlds, policy_.make};
}

nlohmann::ordered_json Setup::provenance(const RunConfiguration& configuration) const {
  nlohmann::ordered_json result = sim2sim::provenance(
      configuration, policy_.provenance, {{"scene", {{"file", scene_->path().string()}, {"sha256", scene_->sha256()}}}},
      nlohmann::json::object());
  result["code"] = code_;
  return result;
}

nlohmann::json Setup::identity() const { return {{"policy", policy_.identity}, {"scene", scene_->sha256()}}; }

nlohmann::json Setup::referenceKey(int horizon) const {
  nlohmann::json code = code_;
  code.erase(kEngineLibrary);
  return {{"inputs", identity()}, {"horizon", horizon}, {"code", code}};
}

}  // namespace sim2sim
