// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/physics_numbers.hpp"

#include <algorithm>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

constexpr double kMost = 1e6;  // of a number that needs no other bound

/// Gives the tee another mass [kg]; its shares in bar and stem stay.
void setTeeMass(Physics& physics, double mass) {
  const double factor = mass / physics.tee_mass;
  physics.tee_mass = mass;
  physics.tee_first_moment *= factor;
  physics.tee_second_moment *= factor;
}

PhysicsNumber number(const char* name, const char* unit, const char* meaning, double least, double greatest,
                     double (*of)(const Physics&), void (*set)(Physics&, double)) {
  ParameterDescriptor descriptor{name, unit, meaning, of(Physics()), least, greatest};
  descriptor.of_task = true;
  return {descriptor, of, set};
}

/// Number that is a member of Physics.
template <double Physics::*Member>
PhysicsNumber member(const char* name, const char* unit, const char* meaning, double least, double greatest) {
  return number(
      name, unit, meaning, least, greatest, [](const Physics& physics) { return physics.*Member; },
      [](Physics& physics, double value) { physics.*Member = value; });
}

}  // namespace

const std::vector<PhysicsNumber>& physicsNumbers() {
  static const std::vector<PhysicsNumber> numbers = {
      number(
          "tee_body_mass", "kg", "mass of the tee; its shares in bar and stem stay", kLeastMass, kMostMass,
          [](const Physics& physics) { return physics.tee_mass; }, setTeeMass),
      member<&Physics::pusher_mass>("pusher_body_mass", "kg", "mass of the pusher", kLeastMass, kMostMass),
      member<&Physics::contact_friction>("contact_friction", "", "coefficient of sliding friction in contacts", 0.0,
                                         10.0),
      member<&Physics::tee_damping>("tee_damping", "N s/m", "viscous friction of the tee with the table, per axis", 0.0,
                                    kMost),
      member<&Physics::tee_yaw_damping>("tee_yaw_damping", "N m s", "viscous friction of the tee's yaw", 0.0, kMost),
      number(
          "tee_friction", "N", "Coulomb friction of the tee with the table, per axis", 0.0, kMost,
          [](const Physics& physics) { return physics.tee_friction[0]; },
          [](Physics& physics, double value) {
            physics.tee_friction = {value, value};
          }),
      member<&Physics::tee_yaw_friction>("tee_yaw_friction", "N m", "Coulomb friction of the tee's yaw", 0.0, kMost),
      member<&Physics::pusher_damping>("pusher_damping", "N s/m", "viscous friction of the pusher, per axis", 0.0,
                                       kMost),
      member<&Physics::servo_gain>("servo_gain", "N s/m", "gain of the pusher's velocity servo, per axis", 0.0, kMost),
      member<&Physics::servo_limit>("servo_limit", "N", "largest force of the pusher's servo, per axis", 1e-3, kMost),
  };
  return numbers;
}

const ParameterDescriptor& physicsDescriptor(const std::string& name) {
  const auto& numbers = physicsNumbers();
  const auto found = std::find_if(numbers.begin(), numbers.end(),
                                  [&](const PhysicsNumber& each) { return each.descriptor.name == name; });
  if (found == numbers.end()) {
    throw InternalError("physics has no number '" + name + "'");
  }
  return found->descriptor;
}

std::vector<ParameterDescriptor> physicsDescriptors() {
  std::vector<ParameterDescriptor> descriptors;
  for (const PhysicsNumber& each : physicsNumbers()) {
    descriptors.push_back(each.descriptor);
    descriptors.back().only_if_changed = true;
  }
  return descriptors;
}

Physics physicsWith(const ParameterSet& set, Physics physics) {
  for (const PhysicsNumber& each : physicsNumbers()) {
    if (const Parameter& parameter = set.at(each.descriptor.name); !parameter.isDefault()) {
      each.set(physics, std::get<double>(parameter.value));
    }
  }
  return physics;
}

}  // namespace pusht
