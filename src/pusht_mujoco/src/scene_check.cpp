// SPDX-License-Identifier: BSD-3-Clause
#include "scene_check.hpp"

#include <mujoco/mjxmacro.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"

namespace pusht {
namespace {

enum class Kind { kReal, kSmallReal, kInteger, kByte, kCharacter };

template <class Number>
constexpr Kind kKindOf = std::is_same_v<Number, mjtNum>    ? Kind::kReal
                         : std::is_same_v<Number, float>   ? Kind::kSmallReal
                         : std::is_same_v<Number, int>     ? Kind::kInteger
                         : std::is_same_v<Number, mjtByte> ? Kind::kByte
                                                           : Kind::kCharacter;

/// An array of numbers in a model.
struct Field {
  std::string_view name;
  Kind kind;
  const void* numbers;
  int rows;
  int columns;

  std::size_t numberSize() const {
    return kind == Kind::kReal ? sizeof(mjtNum) : kind == Kind::kByte || kind == Kind::kCharacter ? 1 : sizeof(int);
  }
  const void* at(int row, int column) const {
    return static_cast<const char*>(numbers) + numberSize() * static_cast<std::size_t>(row * columns + column);
  }
  std::string text(int row, int column) const {
    const void* number = at(row, column);
    switch (kind) {
      case Kind::kReal:
        return shortestText(*static_cast<const mjtNum*>(number));
      case Kind::kSmallReal:
        return shortestText(*static_cast<const float*>(number));
      case Kind::kInteger:
        return std::to_string(*static_cast<const int*>(number));
      default:
        return std::to_string(*static_cast<const mjtByte*>(number));
    }
  }
};

template <class Number>
Field field(std::string_view name, const Number* numbers, int rows, int columns) {
  return {name, kKindOf<Number>, numbers, rows, columns};
}

/// All numbers of a model, in MuJoCo's own lists; those of its visualization aside.
std::vector<Field> fieldsOf(const mjModel& model) {
  std::vector<Field> fields;
  [[maybe_unused]] const mjModel* m = &model;
  MJMODEL_POINTERS_PREAMBLE(m)
#define X(type, name) fields.push_back(field("option " #name, &model.opt.name, 1, 1));
  MJOPTION_SCALARS
#undef X
#define X(name, count) fields.push_back(field("option " #name, model.opt.name, 1, count));
  MJOPTION_VECTORS
#undef X
#define X(name) fields.push_back(field(#name, &model.name, 1, 1));
  MJMODEL_INTS
#undef X
  fields.push_back(field("statistic meaninertia", &model.stat.meaninertia, 1, 1));
#define X(type, name, rows, columns) fields.push_back(field(#name, model.name, model.rows, columns));
  MJMODEL_POINTERS
#undef X
  return fields;
}

bool startsWithAny(std::string_view text, std::initializer_list<std::string_view> beginnings) {
  return std::any_of(beginnings.begin(), beginnings.end(),
                     [text](std::string_view beginning) { return text.substr(0, beginning.size()) == beginning; });
}

bool endsWithAny(std::string_view text, std::initializer_list<std::string_view> ends) {
  return std::any_of(ends.begin(), ends.end(), [text](std::string_view end) {
    return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
  });
}

/// Says how the scene looks or what it is called, or where that is stored.
bool isLooks(std::string_view name) {
  return startsWithAny(name, {"ngeom", "nsite", "ncam", "nlight", "nmesh", "nskin", "nhfield", "ntex", "nmat",
                              "nnumeric", "ntuple", "nkey", "nuser_", "nnames", "nbuffer", "nstack"}) ||
         startsWithAny(name, {"site_", "cam_", "light_", "mesh_", "skin_", "hfield_", "tex_", "mat_", "numeric_",
                              "text_", "tuple_", "key_", "name_", "names", "body_geom"}) ||
         endsWithAny(name, {"_rgba", "_group", "_matid", "_user"});
}

/// How far a number is from what the file says. What is nearest says best what is wrong.
enum class Origin { kFile, kMass, kInertia, kDerived };

Origin originOf(std::string_view name) {
  if (name == "body_mass") {
    return Origin::kMass;
  }
  if (startsWithAny(name, {"body_ipos", "body_iquat", "body_inertia"})) {
    return Origin::kInertia;
  }
  const bool is_derived = startsWithAny(name, {"statistic"}) ||
                          endsWithAny(name, {"_subtreemass", "_invweight0", "_M0", "_acc0", "_length0", "_lengthrange",
                                             "_simple", "_simplenum", "_sameframe", "_rbound"});
  return is_derived ? Origin::kDerived : Origin::kFile;
}

std::string nameOf(const mjModel& model, int type, int id) {
  const char* name = mj_id2name(&model, type, id);
  return name == nullptr ? "" : name;
}

/// "joint tee_x", of whom `row` of a field speaks; empty if of the model as a whole.
std::string ownerOf(const mjModel& model, std::string_view field, int row) {
  if (startsWithAny(field, {"body_"})) {
    return "body " + nameOf(model, mjOBJ_BODY, row);
  }
  if (startsWithAny(field, {"jnt_", "dof_", "qpos"})) {  // one coordinate a joint, or the sizes would differ
    return "joint " + nameOf(model, mjOBJ_JOINT, row);
  }
  if (startsWithAny(field, {"geom_"})) {
    return "geom " + nameOf(model, mjOBJ_GEOM, row);
  }
  return startsWithAny(field, {"actuator_"}) ? "actuator " + nameOf(model, mjOBJ_ACTUATOR, row) : "";
}

std::vector<int> firstIds(int count) {
  std::vector<int> ids(static_cast<std::size_t>(count));
  for (int id = 0; id < count; ++id) {
    ids[static_cast<std::size_t>(id)] = id;
  }
  return ids;
}

/// The others are for the eye.
std::vector<int> collidingGeoms(const mjModel& model) {
  std::vector<int> geoms;
  for (int geom = 0; geom < model.ngeom; ++geom) {
    if (model.geom_contype[geom] != 0 || model.geom_conaffinity[geom] != 0) {
      geoms.push_back(geom);
    }
  }
  return geoms;
}

[[noreturn]] void refuse(const std::string& what, const std::string& value, const std::string& expected) {
  throw InvalidInput(what + " is " + value + ": must be " + expected + "; a scene may only look different");
}

void checkNames(const mjModel& model, const mjModel& of_task, int type, const std::vector<int>& ids,
                const std::vector<int>& expected_ids) {
  const std::string what = type == mjOBJ_GEOM ? "colliding geom" : mju_type2Str(type);
  for (std::size_t i = 0; i < std::min(ids.size(), expected_ids.size()); ++i) {
    const std::string name = nameOf(model, type, ids[i]);
    const std::string expected = nameOf(of_task, type, expected_ids[i]);
    if (name != expected) {
      refuse(what + " " + std::to_string(i), "'" + name + "'", "'" + expected + "'");
    }
  }
  if (ids.size() != expected_ids.size()) {
    refuse("number of " + what + "s", std::to_string(ids.size()), std::to_string(expected_ids.size()));
  }
}

void checkField(const mjModel& model, const Field& found, const std::vector<int>& rows, const Field& expected,
                const std::vector<int>& expected_rows) {
  for (std::size_t i = 0; i < expected_rows.size(); ++i) {
    for (int column = 0; column < expected.columns; ++column) {
      if (std::memcmp(found.at(rows[i], column), expected.at(expected_rows[i], column), found.numberSize()) != 0) {
        std::string what = ownerOf(model, found.name, rows[i]);
        what.append(what.empty() ? "" : " ").append(found.name);
        if (found.columns > 1) {
          what += "[" + std::to_string(column) + "]";
        }
        refuse(what, found.text(rows[i], column), expected.text(expected_rows[i], column));
      }
    }
  }
}

}  // namespace

void checkScene(const mjModel& model, const mjModel& of_task) {
  checkNames(model, of_task, mjOBJ_BODY, firstIds(model.nbody), firstIds(of_task.nbody));
  checkNames(model, of_task, mjOBJ_JOINT, firstIds(model.njnt), firstIds(of_task.njnt));
  checkNames(model, of_task, mjOBJ_ACTUATOR, firstIds(model.nu), firstIds(of_task.nu));
  checkNames(model, of_task, mjOBJ_GEOM, collidingGeoms(model), collidingGeoms(of_task));

  const std::vector<Field> found = fieldsOf(model);
  const std::vector<Field> expected = fieldsOf(of_task);
  for (const Origin origin : {Origin::kFile, Origin::kMass, Origin::kInertia, Origin::kDerived}) {
    for (std::size_t i = 0; i < expected.size(); ++i) {
      if (isLooks(expected[i].name) || originOf(expected[i].name) != origin) {
        continue;
      }
      if (startsWithAny(expected[i].name, {"geom_"})) {
        checkField(model, found[i], collidingGeoms(model), expected[i], collidingGeoms(of_task));
      } else {
        checkField(model, found[i], firstIds(expected[i].rows), expected[i], firstIds(expected[i].rows));
      }
    }
  }
}

}  // namespace pusht
