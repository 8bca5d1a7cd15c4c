// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/comparison.hpp"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <iostream>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_policy/network_policy.hpp"
#include "pusht_policy/scripted_expert.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/ros/installed_file.hpp"
#include "sim2sim_eval/command_line.hpp"
#include "sim2sim_eval/protocol.hpp"
#include "sim2sim_eval/provenance.hpp"
#include "sim2sim_eval/report.hpp"
#include "sim2sim_eval/run_folder.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kShipped = "bc";
constexpr const char* kExpert = "expert";
constexpr const char* kUntrained = "fresh-untrained";

constexpr int kSmokeEpisodes = 2;
constexpr int kSmokeHorizon = 40;  // [control steps]

struct NamedPolicy {
  std::unique_ptr<pusht::Policy> policy;
  std::string name;
  nlohmann::json provenance;
};

NamedPolicy named(std::unique_ptr<pusht::NetworkPolicy> policy, const std::string& name) {
  const pusht::NetworkInfo& info = policy->info();
  nlohmann::json provenance = {{"sha256", info.sha256},
                               {"runs_on", info.runsOnKernel() ? "fixed-order kernel" : "libtorch"},
                               {"libtorch", info.libtorch_version},
                               {"blas", info.blas}};
  if (info.runsOnKernel()) {
    provenance["operations"] = info.operations;
    provenance["instruction_set"] = info.instruction_set;
  } else {
    provenance["note"] = "the bits of this run depend on the BLAS; not on the kernel: " + info.why_not_on_kernel;
  }
  return {std::move(policy), name, std::move(provenance)};
}

NamedPolicy untrained(std::uint64_t seed) { return named(pusht::NetworkPolicy::untrained(seed), kUntrained); }

NamedPolicy choosePolicy(const CompareOptions& options) {
  if (options.smoke) {
    return untrained(options.seed);
  }
  if (options.policy == kExpert) {
    return {std::make_unique<pusht::ScriptedExpert>(), kExpert, {{"runs_on", "scripted"}}};
  }
  if (options.policy == kShipped) {
    return named(pusht::NetworkPolicy::load(pusht::installedFile("pusht_policy", "policies/bc_policy.ts.pt")),
                 kShipped);
  }
  std::error_code ignored;
  const bool missing = fs::status(options.policy, ignored).type() == fs::file_type::not_found;
  if (options.require_policy || options.policy.empty() || !missing) {
    return named(pusht::NetworkPolicy::load(options.policy), options.policy);
  }
  // The course's guard, the one place where a measurement goes on with something else than was asked for.
  std::cerr << "WARNING: policy " << options.policy << ": there is no such file. Running an UNTRAINED policy instead: "
            << "success and transfer say nothing until --policy names a trained one." << std::endl;
  return untrained(options.seed);
}

RunConfiguration configure(const CompareOptions& options, const std::string& policy_name) {
  RunConfiguration configuration;
  configuration.protocol.seed = options.seed;
  configuration.protocol.episodes = options.smoke ? kSmokeEpisodes : options.episodes;
  configuration.protocol.horizon = options.smoke ? kSmokeHorizon : pusht::kHorizon;
  configuration.knobs = options.knobs;
  configuration.policy = policy_name;
  configuration.smoke = options.smoke;
  configuration.nominal_episodes = options.episodes;
  return configuration;
}

fs::path scenePath(const CompareOptions& options) {
  return options.scene.empty() ? pusht::installedFile("pusht_mujoco", "scenes/pusht.xml") : fs::path(options.scene);
}

nlohmann::json provenance(const RunConfiguration& configuration, const NamedPolicy& policy,
                          const pusht::MujocoScene& scene) {
  return {{"policy", policy.provenance},
          {"scene", {{"file", scene.path().string()}, {"sha256", scene.sha256()}}},
          {"configuration", describe(configuration)},
          {"software", buildAndMachine()}};
}

/// Everything an episode of a run needs, and what has come of it.
class Run {
 public:
  Run(RunConfiguration configuration, pusht::Policy& policy, std::shared_ptr<const pusht::MujocoScene> scene)
      : configuration_(std::move(configuration)), policy_(policy), scene_(std::move(scene)) {}

  void run() {
    const Protocol& protocol = configuration_.protocol;
    ProgressBar bar("episodes", protocol.episodes);
    int reference_successes = 0;
    int engine_successes = 0;
    const auto deliver = [&](const EpisodeResult& episode) {
      episodes_.push_back(episode);
      reference_successes += episode.modes[kReferenceClosed].success ? 1 : 0;
      engine_successes += episode.modes[kEngineClosed].success ? 1 : 0;
      bar.update(static_cast<int>(episodes_.size()),
                 "success " + std::to_string(reference_successes) + " : " + std::to_string(engine_successes));
    };
    runProtocol(
        protocol, [this] { return makeWorlds(); }, policy_, deliver, interrupted);
    if (static_cast<int>(episodes_.size()) < protocol.episodes) {
      throw pusht::RuntimeFault("interrupted after " + std::to_string(episodes_.size()) + " of " +
                                std::to_string(protocol.episodes) + " episodes");
    }
  }

  /// The finished episodes, by index.
  std::vector<EpisodeResult> episodes() const {
    std::vector<EpisodeResult> sorted = episodes_;
    std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.index < b.index; });
    return sorted;
  }

 private:
  Worlds makeWorlds() const {
    return {std::make_unique<pusht::MujocoWorld>(scene_), std::make_unique<pusht::TwoMassEngine>(configuration_.knobs),
            std::make_unique<pusht::TwoMassEngine>(configuration_.knobs)};
  }

  RunConfiguration configuration_;
  pusht::Policy& policy_;
  std::shared_ptr<const pusht::MujocoScene> scene_;
  std::vector<EpisodeResult> episodes_;
};

/// Keeps what an unfinished run has found, and says so. What keeps it from being written is not reported: the
/// failure that ended the run is.
void keepFinished(const RunFolder& folder, const Run& run, const std::exception& failure, int episodes) {
  const std::vector<EpisodeResult> finished = run.episodes();
  const auto count = static_cast<int>(finished.size());
  const pusht::ExitCode code = pusht::exitCodeOf(failure);
  if (count > 0 && code != pusht::ExitCode::kInternalError) {
    std::cout << "NOT A WHOLE RUN: " << count << " of " << episodes << " episodes\n"
              << table(summarize(finished)) << "finished episodes: " << (folder.path() / "episodes.csv").string()
              << std::endl;
  }
  try {
    folder.abandon(finished, {code, failure.what(), count, episodes});
  } catch (const pusht::RuntimeFault&) {
    std::cout << "the finished episodes could not be written" << std::endl;
  }
}

void warnIfUntrained(const std::string& policy, const Summary& summary) {
  if (policy != kUntrained && summary.reference.successes == 0) {
    std::cerr << "WARNING: policy " << policy << " never succeeds in the reference, the simulator it was trained in. "
              << "It looks untrained or stale: the figures measure the policy, not the gap between the simulators."
              << std::endl;
  }
}

}  // namespace

void CompareOptions::declare(CLI::App& app) {
  app.add_option("--policy", policy,
                 "TorchScript file (observation[10] to action[2]), 'bc' for the shipped policy, or 'expert'")
      ->capture_default_str();
  CLI::Option* const require =
      app.add_flag("--require-policy", require_policy, "a missing policy is an error, not a warning");
  app.add_option("--episodes", episodes, "number of episodes")->check(decimalInteger())->capture_default_str();
  app.add_option("--seed", seed, "episode i starts from spawn seed 10000 + seed + i")
      ->check(decimalInteger())
      ->capture_default_str();
  app.add_option("--pusher_mass", knobs.pusher_mass, "engine: inertia of the pusher in contact [kg]")
      ->check(decimalReal())
      ->capture_default_str();
  app.add_option("--block_damp", knobs.block_damp, "engine: viscous drag rate of the tee [1/s]")
      ->check(decimalReal())
      ->capture_default_str();
  app.add_option("--baumgarte", knobs.baumgarte, "engine: stabilisation frequency of the tee's link [rad/s]")
      ->check(decimalReal())
      ->capture_default_str();
  app.add_flag("--smoke", smoke, "short fixed run of an untrained policy, whatever --policy says: 2 episodes, 40 steps")
      ->excludes(require);
  app.add_option("--scene", scene, "MJCF file of the reference instead of the installed one; must be this task");
  app.add_option("--out", out, "folder for the results (default: the next free results/compare-N)");
  app.add_flag("--overwrite", overwrite, "replace results that are in the folder already");
}

void compare(const CompareOptions& options) {
  catchInterrupts();

  // All that can be refused is refused before anything is written.
  configure(options, "").protocol.validate();
  options.knobs.validate();
  RunFolder folder(options.out, options.overwrite);
  const auto scene = std::make_shared<const pusht::MujocoScene>(scenePath(options));
  const NamedPolicy policy = choosePolicy(options);
  const RunConfiguration configuration = configure(options, policy.name);
  folder.begin(provenance(configuration, policy, *scene));

  Run run(configuration, *policy.policy, scene);
  try {
    run.run();
  } catch (const std::exception& failure) {
    keepFinished(folder, run, failure, configuration.protocol.episodes);
    throw;
  }

  const Summary summary = summarize(run.episodes());
  std::cout << "policy " << policy.name << ", seed " << options.seed << ", horizon " << configuration.protocol.horizon
            << " control steps\n"
            << table(summary) << "results: " << folder.path().string() << "\n"
            << "config_hash: " << configurationHash(configuration) << std::endl;
  folder.finish(configuration, run.episodes());
  warnIfUntrained(policy.name, summary);
}

}  // namespace sim2sim
