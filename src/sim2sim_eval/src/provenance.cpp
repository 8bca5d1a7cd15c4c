// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/provenance.hpp"

#include <gnu/libc-version.h>
#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <string>

namespace sim2sim {
namespace {

std::string eigenVersion() {
  return std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
         std::to_string(EIGEN_MINOR_VERSION);
}

/// Those that libm, BLAS and our kernel choose their code by.
nlohmann::json cpuFeatures() {
  nlohmann::json features = nlohmann::json::array();
#if defined(__x86_64__)
  const auto note = [&features](const char* name, int supported) {
    if (supported != 0) {
      features.push_back(name);
    }
  };
  note("avx", __builtin_cpu_supports("avx"));
  note("avx2", __builtin_cpu_supports("avx2"));
  note("avx512f", __builtin_cpu_supports("avx512f"));
  note("fma", __builtin_cpu_supports("fma"));
#endif
  return features;
}

}  // namespace

nlohmann::ordered_json provenance(const RunConfiguration& configuration, const nlohmann::json& policy,
                                  const nlohmann::json& reference, const nlohmann::json& engine) {
  return {{"configuration", describe(configuration)},
          {"policy", policy},
          {"reference", reference},
          {"engine", engine},
          {"software", buildAndMachine()}};
}

nlohmann::json buildAndMachine() {
  return {{"sim2sim_eval", SIM2SIM_EVAL_VERSION},
          {"compiler", __VERSION__},
          {"build_type", SIM2SIM_EVAL_BUILD_TYPE},
          {"mujoco", mj_versionString()},
          {"eigen", eigenVersion()},
          {"libc", std::string("glibc ") + gnu_get_libc_version()},
          {"cpu_features", cpuFeatures()}};
}

}  // namespace sim2sim
