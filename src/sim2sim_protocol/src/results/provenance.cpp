// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/provenance.hpp"

#include <gnu/libc-version.h>
#include <link.h>

#include <Eigen/Core>
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"

namespace sim2sim {
namespace {

std::string eigenVersion() {
  return std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
         std::to_string(EIGEN_MINOR_VERSION);
}

/// CPU features by which libm, BLAS and our kernel choose their code.
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

/// glibc chooses other code for sin, cos, atan2 and others then, which rounds otherwise.
bool libmUsesFma() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("fma") != 0 && __builtin_cpu_supports("avx2") != 0;
#else
  return true;
#endif
}

/// Calls function(path) for every library that is loaded.
template <class Function>
void forEachLibrary(Function function) {
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t /*size*/, void* data) {
        (*static_cast<Function*>(data))(std::filesystem::path(info->dlpi_name));
        return 0;
      },
      &function);
}

}  // namespace

nlohmann::ordered_json provenance(const RunConfiguration& configuration, const nlohmann::json& policy,
                                  const nlohmann::json& reference, const nlohmann::json& engine) {
  nlohmann::ordered_json provenance = {{"configuration", describe(configuration)},
                                       {"policy", policy},
                                       {"reference", reference},
                                       {"engine", engine},
                                       {"software", buildAndMachine()}};
  if (const pusht::Task& task = configuration.protocol.runTask(); &task != &pusht::fullCircle()) {
    provenance["task"] = pusht::describe(task);
  }
  if (configuration.protocol.initial_states) {
    provenance["starts"] = configuration.protocol.initial_states->csv();
  }
  return provenance;
}

nlohmann::json buildAndMachine() {
  return {{"sim2sim_eval", SIM2SIM_VERSION},
          {"compiler", __VERSION__},
          {"build_type", SIM2SIM_BUILD_TYPE},
          {"eigen", eigenVersion()},
          {"libc", std::string("glibc ") + gnu_get_libc_version()},
          {"cpu_features", cpuFeatures()}};
}

std::vector<Input> filesIn(const nlohmann::json& provenance) {
  std::vector<Input> files;
  for (const auto& [name, entry] : provenance.items()) {
    if (entry.is_object() && entry.contains("file") && entry.at("file").is_string()) {
      files.push_back({name, entry.at("file").get<std::string>()});
    }
  }
  return files;
}

nlohmann::json codeFingerprint(const std::vector<std::string>& libraries, const std::vector<std::string>& if_loaded) {
  nlohmann::json fingerprint = {{"libm_uses_fma", libmUsesFma()}};
  forEachLibrary([&](const std::filesystem::path& path) {
    const std::string file = path.filename();
    const auto begins = [&](const std::string& library) {  // a version may follow
      return file.compare(0, library.size(), library) == 0;
    };
    if (const auto library = std::find_if(libraries.begin(), libraries.end(), begins); library != libraries.end()) {
      fingerprint[*library] = pusht::sha256OfFile(path, "library");
    } else if (std::any_of(if_loaded.begin(), if_loaded.end(), begins)) {
      fingerprint[file] = pusht::sha256OfFile(path, "library");
    }
  });
  for (const std::string& library : libraries) {
    if (!fingerprint.contains(library)) {
      throw pusht::InternalError("library " + library + ": is not loaded");
    }
  }
  return fingerprint;
}

}  // namespace sim2sim
