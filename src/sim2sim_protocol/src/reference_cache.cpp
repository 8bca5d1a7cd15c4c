// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/reference_cache.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <system_error>
#include <utility>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/json_text.hpp"
#include "sim2sim_protocol/probes.hpp"
#include "sim2sim_protocol/results/result_files.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;

/// "format" in the first line of a file.
std::string formatText() { return "reference rollout " + std::to_string(kRolloutFormat); }

constexpr std::size_t kKeyDigits = 16;  // of the hash that names what is kept under a key

/// The numbers of a state, in the order in which they are kept.
using StateNumbers = std::array<double, 10>;

StateNumbers numbersOf(const pusht::WorldState& s) {
  return {s.pusher_position.x(), s.pusher_position.y(), s.pusher_velocity.x(),
          s.pusher_velocity.y(), s.tee_position.x(),    s.tee_position.y(),
          s.tee_velocity.x(),    s.tee_velocity.y(),    s.tee_yaw,
          s.tee_yaw_rate};
}

pusht::WorldState stateOf(const StateNumbers& n) {
  return {{n[0], n[1]}, {n[2], n[3]}, {n[4], n[5]}, {n[6], n[7]}, n[8], n[9]};
}

std::string bytesOf(const pusht::Trace& trace) {
  std::vector<StateNumbers> states;
  std::transform(trace.states.begin(), trace.states.end(), std::back_inserter(states), numbersOf);
  std::string bytes(reinterpret_cast<const char*>(states.data()), states.size() * sizeof(StateNumbers));
  bytes.append(reinterpret_cast<const char*>(trace.actions.data()), trace.actions.size() * sizeof(pusht::Action));
  return bytes;
}

/// Trace of `steps` control steps; `bytes` has byteCount(steps) of them.
pusht::Trace traceOf(const char* bytes, std::size_t steps) {
  std::vector<StateNumbers> states(steps + 1);
  std::memcpy(states.data(), bytes, states.size() * sizeof(StateNumbers));
  pusht::Trace trace;
  std::transform(states.begin(), states.end(), std::back_inserter(trace.states), stateOf);
  trace.actions.resize(steps);
  std::memcpy(trace.actions.data(), bytes + states.size() * sizeof(StateNumbers), steps * sizeof(pusht::Action));
  return trace;
}

std::size_t byteCount(std::size_t steps) { return (steps + 1) * sizeof(StateNumbers) + steps * sizeof(pusht::Action); }

}  // namespace

std::string keptName(const nlohmann::json& key) { return pusht::sha256(key.dump()).substr(0, kKeyDigits); }

ReferenceCache::ReferenceCache(const fs::path& folder, nlohmann::json key) : key_(std::move(key)) {
  folder_ = folder / keptName(key_);
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) {
    throw pusht::RuntimeFault("cannot create " + folder_.string() + ": " + error.message());
  }
}

fs::path ReferenceCache::fileOf(const std::string& state, const std::string& rollout) const {
  return folder_ / (state + "." + rollout);
}

std::string ReferenceCache::folderPattern() { return "[0-9a-f]{" + std::to_string(kKeyDigits) + "}"; }

std::string ReferenceCache::filePattern() {
  std::string rollouts = kReferenceRollout;
  for (const Probe& probe : floorProbes()) {
    rollouts += "|" + probe.name;
  }
  return "[0-9a-f]+(#[0-9]+)?\\.(" + rollouts + "|(closed_)?variant_[\\w=.:+-]+)";
}

std::optional<pusht::Trace> ReferenceCache::find(const std::string& state, const std::string& rollout) const {
  const fs::path file = fileOf(state, rollout);
  std::error_code ignored;
  if (fs::symlink_status(file, ignored).type() == fs::file_type::not_found) {
    return std::nullopt;
  }
  const std::string remedy = "; delete it to have the reference rolled out again";
  const auto refuse = [&](const std::string& why) {
    throw pusht::BadDependency("reference cache " + file.string() + ": " + why + remedy);
  };
  std::string text;
  try {
    text = pusht::readFile(file, "reference cache");
  } catch (const pusht::InvalidInput& error) {
    throw pusht::BadDependency(std::string(error.what()) + remedy);
  }
  const std::size_t end_of_head = std::min(text.find('\n'), text.size());
  const auto head = pusht::parseJson(text.substr(0, end_of_head));
  const nlohmann::json format = head.is_object() ? head.value("format", nlohmann::json()) : nlohmann::json();
  if (format.is_string() && format != formatText()) {
    refuse("format " + format.dump() + ": must be \"" + formatText() + "\"; another version of the suite wrote it");
  }
  if (format != formatText() || !head.value("steps", nlohmann::json()).is_number_unsigned() ||
      end_of_head == text.size()) {
    refuse("must begin as a \"" + formatText() + "\"");
  }
  if (head.value("key", nlohmann::json()) != key_ || head.value("start", nlohmann::json()) != state ||
      head.value("rollout", nlohmann::json()) != rollout) {
    refuse("belongs to another run: its key, start or rollout is not that of this folder");
  }
  const auto steps = head.at("steps").get<std::size_t>();
  const std::string bytes = text.substr(end_of_head + 1);
  if (steps > pusht::kHorizon || bytes.size() != byteCount(steps) ||
      head.value("sha256", nlohmann::json()) != pusht::sha256(bytes)) {
    refuse("is damaged: its numbers are not those that were written");
  }
  return traceOf(bytes.data(), steps);
}

void ReferenceCache::keep(const std::string& state, const std::string& rollout, const pusht::Trace& trace) const {
  const fs::path file = fileOf(state, rollout);
  std::error_code ignored;
  if (fs::exists(file, ignored)) {
    return;
  }
  const std::string bytes = bytesOf(trace);
  const nlohmann::json head = {{"format", formatText()}, {"key", key_},
                               {"start", state},         {"rollout", rollout},
                               {"steps", trace.steps()}, {"sha256", pusht::sha256(bytes)}};
  pusht::writeCacheFile(file, head.dump() + "\n" + bytes);
}

}  // namespace sim2sim
