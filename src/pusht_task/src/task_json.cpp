// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "pusht_task/contact.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/json_text.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"
#include "shipped_tasks.hpp"

namespace pusht {
namespace {

using nlohmann::ordered_json;

constexpr double kLargest = 1e6;  // of a number that needs no other bound
constexpr double kTiny = 1e-6;    // least size [m], mass [kg], moment of inertia [kg m^2]
constexpr double kTable = 10.0;   // [m] largest size and distance

const std::map<std::string, Drive> kDrives = {{"velocity", Drive::kVelocity}, {"position", Drive::kPosition}};
const std::map<std::string, SpawnRule> kSpawnRules = {{"ring", SpawnRule::kRing}, {"gym_pusht", SpawnRule::kGymPusht}};

/// Writes the entries of a task.
class Writer {
 public:
  ordered_json result = ordered_json::object();

  template <class Entries>
  void section(const char* name, const Entries& entries) {
    Writer inner;
    entries(inner);
    result[name] = inner.result;
  }
  template <class Value>
  void entry(const char* name, const Value& value, double /*least*/ = 0.0, double /*greatest*/ = 0.0) {
    result[name] = value;
  }
  template <class Value>
  void entry(const char* name, const std::optional<Value>& value, double /*least*/, double /*greatest*/) {
    result[name] = value ? ordered_json(*value) : ordered_json();
  }
  void numbers(const char* name, std::initializer_list<double*> values, double /*least*/, double /*greatest*/) {
    std::vector<double> numbers(values.size());
    std::transform(values.begin(), values.end(), numbers.begin(), [](const double* value) { return *value; });
    result[name] = numbers;
  }
  template <class Value>
  void word(const char* name, const Value& value, const std::map<std::string, Value>& words) {
    for (const auto& [text, meant] : words) {
      if (meant == value) {
        result[name] = text;
      }
    }
  }
};

/// Reads the entries of a task; what is left out stays as it is. Throws InvalidInput with entry, value and rule.
class Reader {
 public:
  Reader(const ordered_json& content, std::string place) : content_(content), place_(std::move(place)) {
    if (!content.is_object()) {
      throw InvalidInput((place_.empty() ? "it" : place_.substr(0, place_.size() - 1)) + " is " + content.dump() +
                         ": must be an object {...}");
    }
  }

  template <class Entries>
  void section(const char* name, const Entries& entries) {
    if (const ordered_json* found = find(name)) {
      Reader inner(*found, place_ + name + ".");
      entries(inner);
      inner.requireNoOthers();
    }
  }
  void entry(const char* name, double& value, double least, double greatest) {
    if (const ordered_json* found = find(name)) {
      value = number(name, *found, least, greatest);
    }
  }
  void entry(const char* name, std::string& value) {
    if (const ordered_json* found = find(name)) {
      require(found->is_string() && !found->get_ref<const std::string&>().empty(), name, *found, "a text");
      value = found->get<std::string>();
    }
  }
  void entry(const char* name, bool& value) {
    if (const ordered_json* found = find(name)) {
      require(found->is_boolean(), name, *found, "true or false");
      value = found->get<bool>();
    }
  }
  template <class Integer, class = std::enable_if_t<std::is_integral_v<Integer>>>
  void entry(const char* name, Integer& value, double least, double greatest) {
    if (const ordered_json* found = find(name)) {
      require(found->is_number_unsigned() && found->get<double>() >= least && found->get<double>() <= greatest, name,
              *found,
              "an integer from " + std::to_string(static_cast<std::int64_t>(least)) + " to " +
                  std::to_string(static_cast<std::int64_t>(greatest)));
      value = found->get<Integer>();
    }
  }
  template <class Value>
  void entry(const char* name, std::optional<Value>& value, double least, double greatest) {
    if (const ordered_json* found = find(name)) {
      value.reset();
      if (!found->is_null()) {
        value = static_cast<Value>(number(name, *found, least, greatest));
      }
    }
  }
  void numbers(const char* name, std::initializer_list<double*> values, double least, double greatest) {
    const ordered_json* const found = find(name);
    if (found == nullptr) {
      return;
    }
    require(found->is_array() && found->size() == values.size(), name, *found,
            std::to_string(values.size()) + " numbers [...]");
    auto each = found->begin();
    for (double* value : values) {
      *value = number(name, *each++, least, greatest);
    }
  }
  template <class Value>
  void word(const char* name, Value& value, const std::map<std::string, Value>& words) {
    std::string text;
    entry(name, text);
    if (text.empty()) {
      return;
    }
    const auto meant = words.find(text);
    std::vector<std::string> known;
    std::transform(words.begin(), words.end(), std::back_inserter(known), [](const auto& each) { return each.first; });
    require(meant != words.end(), name, text, "one of: " + joined(known));
    value = meant->second;
  }

  /// Throws InvalidInput for an entry that was not asked for.
  void requireNoOthers() const {
    for (const auto& [name, value] : content_.items()) {
      if (known_.count(name) == 0) {
        throw InvalidInput(place_ + name +
                           ": unknown; known: " + joined(std::vector<std::string>(known_.begin(), known_.end())));
      }
    }
  }

 private:
  const ordered_json* find(const char* name) {
    known_.insert(name);
    const auto found = content_.find(name);
    return found == content_.end() ? nullptr : &*found;
  }
  void require(bool holds, const char* name, const ordered_json& value, const std::string& rule) const {
    if (!holds) {
      throw InvalidInput(place_ + name + " " + value.dump() + ": must be " + rule);
    }
  }
  double number(const char* name, const ordered_json& value, double least, double greatest) const {
    require(value.is_number() && value.get<double>() >= least && value.get<double>() <= greatest, name, value,
            "a number from " + shortestText(least) + " to " + shortestText(greatest));
    return value.get<double>();
  }

  const ordered_json& content_;
  std::string place_;
  std::set<std::string> known_;
};

/// Visits all entries of a task, in the order of its file.
template <class Visitor>
void visit(Task& task, Visitor& visitor) {
  Physics& physics = task.physics;
  visitor.entry("name", task.name);
  visitor.section("sizes", [&](auto& of) {
    for (const auto& [name, size] :
         {std::pair("pusher_radius", &physics.pusher_radius), std::pair("bar_half_length", &physics.bar_half_length),
          std::pair("bar_half_width", &physics.bar_half_width),
          std::pair("stem_half_length", &physics.stem_half_length),
          std::pair("stem_half_width", &physics.stem_half_width), std::pair("stem_offset", &physics.stem_offset)}) {
      of.entry(name, *size, kTiny, kTable);
    }
  });
  visitor.section("physics", [&](auto& of) {
    of.entry("tee_body_mass", physics.tee_mass, kLeastMass, kMostMass);
    of.entry("tee_first_moment", physics.tee_first_moment, 0.0, kLargest);
    of.entry("tee_second_moment", physics.tee_second_moment, 1e-12, kLargest);
    of.entry("tee_damping", physics.tee_damping, 0.0, kLargest);
    of.entry("tee_yaw_damping", physics.tee_yaw_damping, 0.0, kLargest);
    of.numbers("tee_friction", {&physics.tee_friction[0], &physics.tee_friction[1]}, 0.0, kLargest);
    of.entry("tee_yaw_friction", physics.tee_yaw_friction, 0.0, kLargest);
    of.entry("table_point", physics.table_point, -kTable, kTable);
    of.entry("contact_friction", physics.contact_friction, 0.0, 10.0);
    of.entry("pusher_body_mass", physics.pusher_mass, kLeastMass, kMostMass);
    of.word("drive", physics.drive, kDrives);
    of.entry("servo_stiffness", physics.servo_stiffness, 0.0, kLargest);
    of.entry("servo_gain", physics.servo_gain, 0.0, kLargest);
    of.entry("servo_limit", physics.servo_limit, 1e-3, kLargest);
    of.entry("pusher_damping", physics.pusher_damping, 0.0, kLargest);
  });
  visitor.section("walls", [&](auto& of) {
    of.numbers("middle", {&physics.wall_middle[0], &physics.wall_middle[1]}, -kTable, kTable);
    of.entry("inner_face", physics.wall_inner_face, kTiny, kTable);
  });
  visitor.numbers("target", {&task.target.position.x(), &task.target.position.y(), &task.target.yaw}, -kTable, kTable);
  visitor.section("frame", [&](auto& of) {
    of.entry("unit", task.frame.unit);
    of.entry("per_meter", task.frame.per_meter, kTiny, kLargest);
    of.numbers("middle", {&task.frame.middle.x(), &task.frame.middle.y()}, -kLargest, kLargest);
    of.entry("y_down", task.frame.y_down);
    of.entry("bar_center", task.frame.bar_center, -kLargest, kLargest);
  });
  visitor.entry("action_limit", task.action_limit, 1e-3, kLargest);
  visitor.section("success", [&](auto& of) {
    of.entry("coverage", task.success.coverage, 0.0, 1.0);
    of.entry("position", task.success.position_tolerance, kTiny, kTable);
    of.entry("angle", task.success.angle_tolerance, kTiny, kPi);
    of.entry("hold", task.success.hold, 1, kHorizon);
  });
  visitor.section("starts", [&](auto& of) {
    of.word("rule", task.spawn, kSpawnRules);
    of.numbers("ring", {&task.ring.least_radius, &task.ring.greatest_radius}, 0.0, kTable);
    of.entry("pusher_bound", task.ring.pusher_bound, kTiny, kTable);
    of.entry("pusher_clearance", task.ring.pusher_clearance, 0.0, kTable);
    of.entry("first_seed", task.first_spawn_seed, 1, 1e15);
  });
}

/// Gives a tee whose mass or sizes a file has the moments of a uniform one, unless the file has these, too.
void completeInertia(const ordered_json& content, Physics& physics) {
  const ordered_json of_physics = content.value("physics", ordered_json::object());
  if (!content.contains("sizes") && !of_physics.contains("tee_body_mass")) {
    return;
  }
  const Physics uniform = withUniformTee(physics);
  if (!of_physics.contains("tee_first_moment")) {
    physics.tee_first_moment = uniform.tee_first_moment;
  }
  if (!of_physics.contains("tee_second_moment")) {
    physics.tee_second_moment = uniform.tee_second_moment;
  }
}

/// Makes tolerances that a file has count in place of the coverage of the task that it is like.
void chooseRule(const ordered_json& content, SuccessRule& rule) {
  const ordered_json success = content.value("success", ordered_json::object());
  if (!success.contains("coverage") && (success.contains("position") || success.contains("angle"))) {
    rule.coverage.reset();
  }
}

/// Throws InvalidInput for numbers that each are in their range, but are no task together.
void requireWhole(const Task& task) {
  const Physics& physics = task.physics;
  if (!(physics.tee_second_moment > physics.tee_first_moment * physics.centerOfMass())) {
    throw InvalidInput("physics.tee_second_moment " + shortestText(physics.tee_second_moment) + ": must be above " +
                       shortestText(physics.tee_first_moment * physics.centerOfMass()) +
                       ", the center of mass's share of it");
  }
  if (physics.drive == Drive::kPosition && !(physics.servo_stiffness > 0.0)) {
    throw InvalidInput("physics.servo_stiffness " + shortestText(physics.servo_stiffness) +
                       ": must be above 0 in a drive to a position");
  }
  if (physics.drive == Drive::kVelocity && !task.frame.isTables()) {
    throw InvalidInput(
        "physics.drive velocity: must be position in a frame of its own: velocities are the table's, m/s");
  }
  if (task.spawn == SpawnRule::kRing && task.ring.least_radius > task.ring.greatest_radius) {
    throw InvalidInput("starts.ring " + shortestText(task.ring.least_radius) + ", " +
                       shortestText(task.ring.greatest_radius) + ": must be in order");
  }
  if (const double gap = wallGapsOf(stateAtTarget(task), task).tee; gap < 0.0) {
    throw InvalidInput("target: must be between the walls; a tee there is " + shortestText(-gap) + " m beyond them");
  }
  spawn(task.first_spawn_seed, task);  // throws if there are no starts
}

/// Task in the text of a file.
Task taskFrom(const std::string& text) {
  const ordered_json content = parseOrderedJson(text);
  if (!content.is_object()) {
    throw InvalidInput("must be a JSON object {...}");
  }
  std::string like = fullCircle().name;
  Task task;
  Reader reader(content, "");
  reader.entry("like", like);
  task = shippedTask(like);
  task.name.clear();
  visit(task, reader);
  reader.requireNoOthers();
  static const std::regex word("[A-Za-z][A-Za-z0-9_-]{0,59}");
  if (!std::regex_match(task.name, word) || isShippedTask(task.name)) {
    throw InvalidInput(
        "name '" + task.name +
        "': must be a word of up to 60 letters, digits, - and _, and not be one of: " + joined(taskNames()));
  }
  completeInertia(content, task.physics);
  const bool is_32_bit = task.spawn == SpawnRule::kGymPusht;
  task.last_spawn_seed = is_32_bit ? gymPusht().last_spawn_seed : fullCircle().last_spawn_seed;
  chooseRule(content, task.success);
  task.target.yaw = wrapAngle(task.target.yaw);
  requireWhole(task);
  return task;
}

/// Task in a text, or in the file of this path.
Task taskIn(const std::string& name) {
  const bool is_text = !name.empty() && name.front() == '{';
  if (!is_text && std::filesystem::path(name).extension() != ".json") {
    throw InvalidInput("task '" + name + "': must be one of: " + joined(taskNames()) + "; or a file NAME.json");
  }
  const std::string text = is_text ? name : readFile(name, "task", kLargestSmallFile);
  try {
    return taskFrom(text);
  } catch (const InvalidInput& refusal) {
    throw InvalidInput("task" + (is_text ? "" : " " + name) + ": " + refusal.what());
  }
}

}  // namespace

ordered_json describe(const Task& task) {
  Task copy = task;
  Writer writer;
  visit(copy, writer);
  return writer.result;
}

std::string textOf(const Task& task) { return isShippedTask(task.name) ? task.name : describe(task).dump(); }

const Task& taskNamed(const std::string& name) {
  if (isShippedTask(name)) {
    return shippedTask(name);
  }
  static std::mutex mutex;
  static std::map<std::string, Task> others;  // by text; they stay where they are: worlds and rollouts point to them
  const std::lock_guard<std::mutex> lock(mutex);
  if (const auto found = others.find(name); found != others.end()) {
    return found->second;
  }
  const Task task = taskIn(name);
  return others.emplace(textOf(task), task).first->second;
}

}  // namespace pusht
