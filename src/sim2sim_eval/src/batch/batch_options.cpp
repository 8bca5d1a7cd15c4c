// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/batch_options.hpp"

#include <sched.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <system_error>

#include "pusht_task/files.hpp"
#include "sim2sim_eval/batch/command_line.hpp"

namespace sim2sim {
namespace {

constexpr int kMostThreads = 1024;

}  // namespace

void BatchOptions::declare(CLI::App& app) {
  app.add_option("--threads", threads,
                 "number of threads; it does not change the results (default: the number of cores)")
      ->check(decimalInteger() & CLI::Range(1, kMostThreads));
  app.add_option("--reference-cache", reference_cache,
                 "folder that keeps what the reference did, for later runs with the same policy and reference")
      ->check(notEmpty());
}

int defaultEpisodes(int usual, const std::filesystem::path& starts) {
  std::error_code ignored;
  if (starts.empty() || !std::filesystem::is_regular_file(starts, ignored)) {
    return usual;
  }
  const std::string text = pusht::readFile(starts, "starts");
  const auto ends = std::count(text.begin(), text.end(), '\n');
  const auto rows = ends + (text.empty() || text.back() == '\n' ? 0 : 1) - 1;  // without the names of the columns
  return static_cast<int>(std::clamp<std::ptrdiff_t>(rows, 1, usual));
}

void GapOptions::declare(CLI::App& app) {
  app.add_flag("--floor,!--no-floor", floor,
               "replay the reference from starts moved by 1e-9 m and 1e-6 m: what tiny changes of the start grow to");
  app.add_option("--reanchor", reanchor,
                 "K,K,...: also replay with the engine put to the reference's state every K control steps; without K: "
                 "1,5,20")
      ->expected(0, 1)
      ->default_str("1,5,20");
  app.add_option("--bound-position", bound.position, "[m] beyond it a rollout has parted from the reference")
      ->check(decimalReal())
      ->capture_default_str();
  app.add_option("--bound-angle", bound.angle, "[rad] the same for the yaw")
      ->check(decimalReal())
      ->capture_default_str();
}

void GapOptions::apply(Protocol& protocol) const {
  protocol.probes = probesOf(floor, reanchorFrom(reanchor));
  protocol.bound = bound;
}

int BatchOptions::threadCount() const {
  cpu_set_t cores;
  return threads > 0 ? threads : sched_getaffinity(0, sizeof(cores), &cores) == 0 ? CPU_COUNT(&cores) : 1;
}

std::optional<ReferenceCache> BatchOptions::references(const Setup& setup, int horizon) const {
  if (reference_cache.empty()) {
    return std::nullopt;
  }
  return ReferenceCache(reference_cache, setup.referenceKey(horizon));
}

}  // namespace sim2sim
