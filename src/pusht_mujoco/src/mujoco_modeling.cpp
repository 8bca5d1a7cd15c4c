// SPDX-License-Identifier: BSD-3-Clause
#include "mujoco_modeling.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include "coordinates.hpp"
#include "mujoco_guard.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/physics_numbers.hpp"
#include "pusht_task/substeps.hpp"

namespace pusht {
namespace {

const std::vector<std::string> kIntegrators = {"Euler", "RK4", "implicit"};  // by mjtIntegrator
const std::vector<std::string> kCones = {"pyramidal", "elliptic"};           // by mjtCone
const std::vector<std::string> kSolvers = {"PGS", "CG", "Newton"};           // by mjtSolver

int idOf(const mjModel& model, int type, const char* name) {
  const int id = mj_name2id(&model, type, name);
  if (id < 0) {
    throw InternalError(std::string("scene without '") + name + "'");
  }
  return id;
}

/// Index of a value among `words`, which are in the order of MuJoCo's enumeration.
int indexIn(const std::vector<std::string>& words, const ParameterValue& value) {
  return static_cast<int>(std::find(words.begin(), words.end(), std::get<std::string>(value)) - words.begin());
}

double real(const ParameterValue& value) { return std::get<double>(value); }

/// Gives a body another mass [kg]; its moments of inertia grow with it.
void setMass(mjModel& model, const char* name, double mass) {
  const int body = idOf(model, mjOBJ_BODY, name);
  const double factor = mass / model.body_mass[body];
  model.body_mass[body] = mass;
  std::for_each_n(model.body_inertia + 3 * body, 3, [factor](mjtNum& moment) { moment *= factor; });
}

/// Calls function(geom) for each geom that collides.
template <class Function>
void forEachCollidingGeom(const mjModel& model, const Function& function) {
  for (int geom = 0; geom < model.ngeom; ++geom) {
    if (model.geom_contype[geom] != 0 || model.geom_conaffinity[geom] != 0) {
      function(geom);
    }
  }
}

void setContact(mjModel& model, mjtNum* parameters, int count, int index, double value) {
  forEachCollidingGeom(model, [&](int geom) { parameters[count * geom + index] = value; });
}

/// Sets the gain of the servos: force = gain * (command - velocity), or with a command that is a position
/// stiffness * (command - position) - gain * velocity.
void setServoGain(mjModel& model, double gain) {
  for (int actuator = 0; actuator < model.nu; ++actuator) {
    if (model.actuator_biasprm[mjNBIAS * actuator + 1] == 0.0) {
      model.actuator_gainprm[mjNGAIN * actuator] = gain;
    }
    model.actuator_biasprm[mjNBIAS * actuator + 2] = -gain;
  }
}

void setServoLimit(mjModel& model, double limit) {
  for (int actuator = 0; actuator < model.nu; ++actuator) {
    model.actuator_forcerange[2 * actuator] = -limit;
    model.actuator_forcerange[2 * actuator + 1] = limit;
  }
}

/// A parameter, and what sets it in a model.
struct Modeling {
  ParameterDescriptor descriptor;
  void (*apply)(mjModel& model, const ParameterValue& value);
};

ParameterDescriptor number(const char* name, const char* unit, const char* meaning, double usual, double least,
                           double greatest, const char* reason = "") {
  return {name, unit, meaning, usual, least, greatest, reason};
}

ParameterDescriptor choice(const char* name, const char* meaning, const char* usual,
                           const std::vector<std::string>& words) {
  ParameterDescriptor descriptor{name, "", meaning, std::string(usual)};
  descriptor.words = words;
  return descriptor;
}

const std::vector<Modeling>& modeling() {
  using Value = const ParameterValue&;
  static const std::vector<Modeling> rows = {
      {substepDescriptor("timestep"), [](mjModel& m, Value v) { m.opt.timestep = real(v); }},
      {choice("integrator", "numerical integrator", "implicit", kIntegrators),
       [](mjModel& m, Value v) { m.opt.integrator = indexIn(kIntegrators, v); }},
      {choice("cone", "shape of the friction cones", "pyramidal", kCones),
       [](mjModel& m, Value v) { m.opt.cone = indexIn(kCones, v); }},
      {choice("solver", "solver of the constraints", "Newton", kSolvers),
       [](mjModel& m, Value v) { m.opt.solver = indexIn(kSolvers, v); }},
      {number("impratio", "", "ratio of frictional to normal impedance of elliptic contacts", 1.0, 1e-3, 1e3),
       [](mjModel& m, Value v) { m.opt.impratio = real(v); }},
      {{"iterations", "", "most iterations of the constraint solver in a time step", std::int64_t{100}, 1.0, 1e4},
       [](mjModel& m, Value v) { m.opt.iterations = static_cast<int>(std::get<std::int64_t>(v)); }},

      {physicsDescriptor("tee_body_mass"), [](mjModel& m, Value v) { setMass(m, "tee", real(v)); }},
      {physicsDescriptor("pusher_body_mass"), [](mjModel& m, Value v) { setMass(m, "pusher", real(v)); }},
      {physicsDescriptor("contact_friction"),
       [](mjModel& m, Value v) { setContact(m, m.geom_friction, 3, 0, real(v)); }},
      {physicsDescriptor("tee_damping"),
       [](mjModel& m, Value v) { m.dof_damping[kTeeX] = m.dof_damping[kTeeY] = real(v); }},
      {physicsDescriptor("tee_yaw_damping"), [](mjModel& m, Value v) { m.dof_damping[kTeeYaw] = real(v); }},
      {physicsDescriptor("tee_friction"),
       [](mjModel& m, Value v) { m.dof_frictionloss[kTeeX] = m.dof_frictionloss[kTeeY] = real(v); }},
      {physicsDescriptor("tee_yaw_friction"), [](mjModel& m, Value v) { m.dof_frictionloss[kTeeYaw] = real(v); }},
      {physicsDescriptor("pusher_damping"),
       [](mjModel& m, Value v) { m.dof_damping[kPusherX] = m.dof_damping[kPusherY] = real(v); }},
      {physicsDescriptor("servo_gain"), [](mjModel& m, Value v) { setServoGain(m, real(v)); }},
      {physicsDescriptor("servo_limit"), [](mjModel& m, Value v) { setServoLimit(m, real(v)); }},
      {number("contact_time", "s", "time constant of contacts (solref[0])", 0.02, 1e-3, 1.0,
              "MuJoCo uses two time steps where it is less"),
       [](mjModel& m, Value v) { setContact(m, m.geom_solref, mjNREF, 0, real(v)); }},
      {number("contact_damping", "", "damping ratio of contacts (solref[1])", 1.0, 1e-3, 100.0),
       [](mjModel& m, Value v) { setContact(m, m.geom_solref, mjNREF, 1, real(v)); }},
      {number("contact_impedance", "", "impedance of a contact at no overlap (solimp[0])", 0.9, mjMINIMP, mjMAXIMP),
       [](mjModel& m, Value v) { setContact(m, m.geom_solimp, mjNIMP, 0, real(v)); }},
      {number("contact_most_impedance", "", "impedance of a contact at full overlap (solimp[1])", 0.95, mjMINIMP,
              mjMAXIMP),
       [](mjModel& m, Value v) { setContact(m, m.geom_solimp, mjNIMP, 1, real(v)); }},
      {number("contact_width", "m", "overlap from which on the impedance is full (solimp[2])", 0.001, 0.0, 1.0),
       [](mjModel& m, Value v) { setContact(m, m.geom_solimp, mjNIMP, 2, real(v)); }},
  };
  return rows;
}

/// Computes what MuJoCo derives from masses and sizes of a model.
void setConstants(mjModel& model) {
  mjData* data = nullptr;
  MujocoGuard::run([&] {
    data = mj_makeData(&model);
    if (data != nullptr) {
      mj_setConst(&model, data);
      mj_deleteData(data);
    }
  });
  if (data == nullptr) {
    throw std::bad_alloc();
  }
}

}  // namespace

const std::vector<ParameterDescriptor>& modelingParameters() {
  static const std::vector<ParameterDescriptor> descriptors = [] {
    std::vector<ParameterDescriptor> all;
    for (const Modeling& row : modeling()) {
      all.push_back(row.descriptor);
    }
    return all;
  }();
  return descriptors;
}

bool changesModel(const ParameterSet& parameters) {
  return std::any_of(modeling().begin(), modeling().end(),
                     [&](const Modeling& row) { return !parameters.at(row.descriptor.name).isDefault(); });
}

void applyModeling(const ParameterSet& parameters, mjModel& model) {
  for (const Modeling& row : modeling()) {
    const Parameter& parameter = parameters.at(row.descriptor.name);
    if (!parameter.isDefault()) {
      row.apply(model, parameter.value);
    }
  }
  setConstants(model);
}

}  // namespace pusht
