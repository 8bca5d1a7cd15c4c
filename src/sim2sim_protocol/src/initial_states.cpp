// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/initial_states.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/split.hpp"
#include "pusht_task/state_fields.hpp"
#include "pusht_task/task.hpp"

namespace sim2sim {
namespace {

using pusht::kStateFields;
using pusht::StateField;
using pusht::WorldState;

/// Column of a file: its name, and the number of a state that it has.
struct Column {
  std::string name;
  StateField field;
};

using Columns = std::vector<Column>;

/// Columns in the table frame.
Columns tableColumns() {
  Columns columns;
  std::transform(kStateFields.begin(), kStateFields.end(), std::back_inserter(columns), [](const StateField& field) {
    return Column{field.name, field};
  });
  return columns;
}

/// Columns in the frame of a task's own: "pusher_x_px", ..., "tee_angle"; none if that is the table frame.
Columns ownColumns(const pusht::Task& task) {
  Columns columns;
  if (task.frame.isTables()) {
    return columns;
  }
  for (const StateField& field : kStateFields) {
    if (!field.isVelocity()) {
      columns.push_back({field.unit == "m" ? field.name + ("_" + task.frame.unit) : "tee_angle", field});
    }
  }
  return columns;
}

Columns::const_iterator named(const Columns& columns, const std::string& name) {
  return std::find_if(columns.begin(), columns.end(), [&](const Column& column) { return column.name == name; });
}

std::string namesOf(const Columns& columns) {
  std::vector<std::string> names;
  std::transform(columns.begin(), columns.end(), std::back_inserter(names), [](const Column& c) { return c.name; });
  return pusht::joined(names);
}

std::string csvRow(WorldState state) {
  std::string row;
  for (const StateField& column : kStateFields) {
    row.append(row.empty() ? "" : ",").append(pusht::shortestText(column.of(state)));
  }
  return row + "\n";
}

/// Layout of a file: its columns, and whether they are in the frame of the task's own.
struct Layout {
  Columns columns;
  bool is_own = false;
};

/// Layout that the first line names.
Layout layoutIn(const std::string& line, const pusht::Task& task) {
  const std::vector<std::string> names = pusht::cellsOf(line);
  const Columns own = ownColumns(task);
  const bool is_own =
      std::any_of(names.begin(), names.end(), [&](const std::string& name) { return named(own, name) != own.end(); });
  const Columns known = is_own ? own : tableColumns();
  Layout layout{{}, is_own};
  for (const std::string& name : names) {
    const auto column = named(known, name);
    if (column == known.end()) {
      throw pusht::InvalidInput("column '" + name + "': must be one of: " + namesOf(known) +
                                (is_own || own.empty() ? "" : "; or all of: " + namesOf(own)));
    }
    if (std::count(names.begin(), names.end(), name) > 1) {
      throw pusht::InvalidInput("column '" + name + "': must appear only once");
    }
    layout.columns.push_back(*column);
  }
  for (const Column& column : known) {
    if (!column.field.isVelocity() && std::find(names.begin(), names.end(), column.name) == names.end()) {
      throw pusht::InvalidInput("column '" + column.name + "': is missing");
    }
  }
  return layout;
}

WorldState stateIn(const std::string& line, const Layout& layout, const pusht::Task& task) {
  const std::vector<std::string> cells = pusht::cellsOf(line);
  if (cells.size() != layout.columns.size()) {
    throw pusht::InvalidInput(std::to_string(cells.size()) + " values: must be " +
                              std::to_string(layout.columns.size()) + ", one for each column");
  }
  WorldState state;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Column& column = layout.columns[i];
    const std::optional<double> number = pusht::decimal<double>(cells[i]);
    if (!number) {
      throw pusht::InvalidInput(column.name + " '" + cells[i] + "': must be a decimal number");
    }
    column.field.of(state) = *number;
  }
  pusht::checkedStart(state);
  const double turns = layout.is_own ? 5.0 : 1.0;  // gym-pusht draws angles of several turns
  if (std::abs(state.tee_yaw) > turns * 2.0 * pusht::kPi) {
    throw pusht::InvalidInput(std::string(layout.is_own ? "tee_angle " : "tee_yaw ") +
                              pusht::shortestText(state.tee_yaw) + " rad: must be within " +
                              (layout.is_own ? "5 turns" : "a turn, 2 pi") + "; degrees?");
  }
  if (layout.is_own) {
    const pusht::Pose tee = task.frame.poseToTable({state.tee_position, state.tee_yaw});
    state.pusher_position = task.frame.pointToTable(state.pusher_position);
    state.tee_position = tee.position;
    state.tee_yaw = tee.yaw;
  }
  return pusht::checkedStart(state);
}

/// "0.3 m", or "0.3 m (556 px)" in a task with a unit of its own.
std::string coordinateText(double meters, std::size_t axis, const pusht::Task& task) {
  std::string text = pusht::shortestText(meters) + " m";
  if (task.frame.isTables()) {
    return text;
  }
  Eigen::Vector2d point = Eigen::Vector2d::Zero();
  point[static_cast<Eigen::Index>(axis)] = meters;
  const double own = task.frame.pointFromTable(point)[static_cast<Eigen::Index>(axis)];
  return text + " (" + pusht::significantText(own, 4) + " " + task.frame.unit + ")";
}

/// Throws InvalidInput if the center of a body is beyond the walls.
void requireOnTable(WorldState state, const pusht::Task& task) {
  constexpr double kOtherUnit = 10.0;  // [m] no table is that large
  for (const StateField& field : kStateFields) {
    const double value = field.of(state);
    const std::size_t axis = std::string(field.name).back() == 'y' ? 1 : 0;
    const double middle = task.physics.wall_middle[axis];
    if (field.unit == "m" && std::abs(value - middle) > task.physics.wall_inner_face) {
      const double end = middle + std::copysign(task.physics.wall_inner_face, value);
      throw pusht::InvalidInput(std::string(field.name) + " " + coordinateText(value, axis, task) +
                                ": the table ends at " +
                                coordinateText(middle == 0.0 ? std::abs(end) : end, axis, task) +
                                (std::abs(value) > kOtherUnit ? "; pixels or millimeters?" : ""));
    }
  }
}

void requireApart(const WorldState& state, const pusht::Task& task) {
  constexpr double kContact = 0.003;  // [m] soft contacts overlap
  const pusht::Overlap overlap = pusht::deepestOverlap(state, task);
  if (overlap.depth > kContact) {
    throw pusht::InvalidInput(std::string(overlap.bodies) + " overlap by " + pusht::significantText(overlap.depth, 2) +
                              " m: must be at most " + pusht::shortestText(kContact) +
                              " m, unless --overlapping-starts allows it");
  }
}

}  // namespace

InitialStates::InitialStates(std::vector<WorldState> states, int first)
    : states_(std::move(states)), first_(first), hash_("sha256:" + pusht::sha256(csv())) {}

InitialStates InitialStates::named(std::string sha256) {
  InitialStates starts({}, 0);
  starts.hash_ = std::move(sha256);
  return starts;
}

const WorldState& InitialStates::at(int episode) const {
  return states_.at(static_cast<std::size_t>(episode - first_));
}

std::string InitialStates::keyOf(int episode) const {
  constexpr std::size_t kDigits = 16;
  return pusht::sha256(csvRow(at(episode))).substr(0, kDigits);
}

std::string InitialStates::csv() const { return initialStatesCsv(states_); }

InitialStates readInitialStates(const std::filesystem::path& path, int first, int count, const pusht::Task& task) {
  const std::string csv = pusht::readFile(path, "starts");
  try {
    return initialStatesFrom(csv, first, count, task);
  } catch (pusht::Error& error) {
    error.addContext("starts " + path.string());
    throw;
  }
}

InitialStates initialStatesFrom(const std::string& csv, int first, int count, const pusht::Task& task) {
  std::istringstream text(csv);
  std::vector<WorldState> states;
  Layout layout;
  int number = 0;
  try {
    for (std::string line; static_cast<int>(states.size()) < count && std::getline(text, line);) {
      if (++number == 1) {
        layout = layoutIn(line, task);
      } else {
        states.push_back(stateIn(line, layout, task));
      }
    }
  } catch (pusht::Error& error) {
    error.addContext("line " + std::to_string(number));
    throw;
  }
  if (static_cast<int>(states.size()) < count) {
    throw pusht::InvalidInput("has " + std::to_string(states.size()) + " rows: must have at least " +
                              std::to_string(count) + ", one for each episode");
  }
  return {std::move(states), first};
}

std::shared_ptr<const InitialStates> givenInitialStates(const std::filesystem::path& path, int first, int count,
                                                        bool may_overlap, const pusht::Task& task) {
  if (path.empty()) {
    return nullptr;
  }
  auto starts = std::make_shared<InitialStates>(readInitialStates(path, first, count, task));
  std::map<std::string, int> lines;  // by key of the start
  for (int episode = first; episode < first + count; ++episode) {
    const int line = episode - first + 2;  // below the names of the columns
    try {
      requireOnTable(starts->at(episode), task);
      if (!may_overlap) {
        requireApart(starts->at(episode), task);
      }
      const auto [same, is_new] = lines.emplace(starts->keyOf(episode), line);
      if (!is_new) {
        throw pusht::InvalidInput("is the start of line " + std::to_string(same->second) +
                                  " again: must be another one; `repeats` plays each start several times");
      }
    } catch (pusht::Error& error) {
      error.addContext("starts " + path.string() + ": line " + std::to_string(line));
      throw;
    }
  }
  return starts;
}

std::string initialStatesCsv(const std::vector<WorldState>& states) {
  std::string csv;
  for (const StateField& column : kStateFields) {
    csv.append(csv.empty() ? "" : ",").append(column.name);
  }
  csv += "\n";
  for (const WorldState& state : states) {
    csv += csvRow(state);
  }
  return csv;
}

}  // namespace sim2sim
