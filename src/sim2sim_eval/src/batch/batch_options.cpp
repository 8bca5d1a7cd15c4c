// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/batch_options.hpp"

#include <sched.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <type_traits>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/loop.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_eval/batch/command_line.hpp"

namespace sim2sim {
namespace {

constexpr int kMostThreads = 1024;
constexpr double kLeastTime = 0.001;        // [s]
constexpr double kGreatestTime = 86'400.0;  // [s]

/// "first-episode"
std::string optionName(std::string name) {
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

template <class Number>
void declareOption(CLI::App& app, const std::string& name, Number& value, const std::string& meaning) {
  app.add_option("--" + name, value, meaning)
      ->check(std::is_integral_v<Number> ? decimalInteger() : decimalReal())
      ->capture_default_str();
}

void declareOption(CLI::App& app, const std::string& name, std::optional<double>& value, const std::string& meaning) {
  app.add_option("--" + name, value, meaning)->check(decimalReal());
}

void declareOption(CLI::App& app, const std::string& name, bool& value, const std::string& meaning) {
  app.add_flag("--" + name + ",!--no-" + name, value, meaning);
}

void declareOption(CLI::App& app, const std::string& name, std::vector<int>& value, const std::string& meaning) {
  constexpr const char* kUsual = "1,5,20";
  app.add_option_function<std::string>(
         "--" + name, [&value](const std::string& text) { value = reanchorFrom(text.empty() ? kUsual : text); },
         meaning)
      ->expected(0, 1)
      ->default_str(kUsual);
}

void declareOption(CLI::App& app, const std::string& name, std::string& value, const std::string& meaning) {
  app.add_option("--" + name, value, meaning)->check(notEmpty())->capture_default_str();
}

void declareOption(CLI::App& app, const std::string& name, std::vector<std::string>& value,
                   const std::string& meaning) {
  app.add_option_function<std::string>(
         "--" + name,
         [&value](const std::string& text) { value = modelVariantsFrom(text.empty() ? kDefaultVariants : text); },
         meaning)
      ->expected(0, 1)
      ->default_str(kDefaultVariants);
}

/// Declares a time in seconds.
void declareTime(CLI::App& app, const std::string& name, std::chrono::milliseconds& time, const std::string& meaning) {
  using Seconds = std::chrono::duration<double>;
  app.add_option_function<double>(
         name,
         [&time](double seconds) { time = std::chrono::duration_cast<std::chrono::milliseconds>(Seconds(seconds)); },
         meaning)
      ->check(decimalReal() & CLI::Range(kLeastTime, kGreatestTime))
      ->default_str(pusht::shortestText(Seconds(time).count()));
}

}  // namespace

void BatchOptions::declare(CLI::App& app) {
  app.add_option("--threads", threads,
                 "number of threads; it does not change the results (default: the number of cores)")
      ->check(decimalInteger() & CLI::Range(1, kMostThreads));
  app.add_option("--reference-cache", reference_cache,
                 "folder that keeps what the reference did, for later runs with the same policy and reference")
      ->check(notEmpty());
  nodeTimes() = {};
  declareTime(app, "--deadline", nodeTimes().deadline, "[s] for each answer of a node that is named as a simulator");
  declareTime(app, "--patience", nodeTimes().patience, "[s] that such a node is waited for");
}

int defaultEpisodes(const RunOptions& options, const std::filesystem::path& starts) {
  const int usual = RunOptions().episodes;
  std::error_code ignored;
  if (starts.empty() || !std::filesystem::is_regular_file(starts, ignored)) {
    return usual;
  }
  const std::string text = pusht::readFile(starts, "starts");
  const auto ends = std::count(text.begin(), text.end(), '\n');
  const auto rows = ends + (text.empty() || text.back() == '\n' ? 0 : 1) - 1;  // without the names of the columns
  return static_cast<int>(std::clamp<std::ptrdiff_t>(rows * options.repeats, 1, usual));
}

void declare(CLI::App& app, RunOptions& options, const std::set<std::string>& names) {
  forEachOption([&](const auto& option) {
    if (names.empty() || names.count(option.name) > 0) {
      declareOption(app, optionName(option.name), option.of(options), option.help());
    }
  });
}

void declareLoop(CLI::App& app, std::vector<std::string>& reference, std::vector<std::string>& engine) {
  using Settings = std::vector<std::string>;
  const auto declare_for = [&app](const std::string& name, const std::string& meaning, std::vector<Settings*> roles) {
    app.add_option_function<Settings>(
           name,
           [roles](const Settings& given) {
             for (Settings* role : roles) {
               std::transform(given.begin(), given.end(), std::back_inserter(*role), [](const std::string& setting) {
                 const auto [parameter, value] = pusht::loopSettingFrom(setting);
                 return pusht::kLoopPrefix + parameter + "=" + value;
               });
             }
           },
           meaning)
        ->allow_extra_args(false);
  };
  Settings names;
  for (const pusht::ParameterDescriptor& parameter : pusht::loopParameters()) {
    names.push_back(parameter.name);
  }
  declare_for(
      "--loop",
      "tracker, a loop as a camera makes it, or NAME=VALUE: a parameter of the loop between policy and world, in "
      "both roles: " +
          pusht::joined(names) + "; may be repeated",
      {&reference, &engine});
  declare_for("--loop-reference", "tracker, or NAME=VALUE: a parameter of the loop of the reference alone",
              {&reference});
  declare_for("--loop-engine", "tracker, or NAME=VALUE: a parameter of the loop of the engine alone", {&engine});
}

int BatchOptions::threadCount() const {
  cpu_set_t cores;
  return threads > 0 ? threads : sched_getaffinity(0, sizeof(cores), &cores) == 0 ? CPU_COUNT(&cores) : 1;
}

std::optional<ReferenceCache> BatchOptions::references(const LoadedRun& loaded, const RunOptions& options) const {
  if (reference_cache.empty()) {
    return std::nullopt;
  }
  const auto& foreign = loaded.reference().foreign;
  if (foreign && foreign->code.value("version", "").empty()) {
    throw pusht::InvalidInput("reference_cache " + reference_cache + ": must be left out: " + foreign->name +
                              " does not say its version");
  }
  return ReferenceCache(reference_cache, loaded.referenceKey(options));
}

}  // namespace sim2sim
