// SPDX-License-Identifier: BSD-3-Clause
/// The two-mass engine as one would write it down first: a list of contacts, always ten sweeps, one world. What the
/// engine does faster must be this, to the last bit.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>

#include "pusht_engine/two_mass_engine.hpp"

namespace pusht::naive {

using two_mass::Body;
using two_mass::BodyScalars;
using two_mass::kBar;
using two_mass::kPusher;
using two_mass::kStem;
using BodyVectors = two_mass::BodyVectors<double>;

struct Contact {
  Body block;
  Eigen::Vector2d normal;
  double depth;
};

class Contacts {
 public:
  void add(const Contact& contact) { contacts_[size_++] = contact; }
  std::size_t size() const { return size_; }
  const Contact& operator[](std::size_t i) const { return contacts_[i]; }

 private:
  std::array<Contact, 2> contacts_{};
  std::size_t size_ = 0;
};

/// Relative velocity [m/s] of the pusher along the normal; negative while they approach.
inline double normalVelocity(const Contact& contact, const BodyVectors& velocities) {
  return velocities[kPusher].dot(contact.normal) - velocities[contact.block].dot(contact.normal);
}

inline Eigen::Vector2d linkForce(const BodyVectors& positions, const BodyVectors& velocities, const BodyScalars& masses,
                                 double baumgarte) {
  const Eigen::Vector2d d = positions[kBar] - positions[kStem];
  const Eigen::Vector2d d_rate = velocities[kBar] - velocities[kStem];
  // Constraint g = (d.d - L^2) / 2 with rate d.d_rate; its Jacobian is d on the bar and -d on the stem.
  const double g = 0.5 * (d.dot(d) - kStemOffset * kStemOffset);
  const double g_rate = d.dot(d_rate);
  const double effective_inverse_mass = (1.0 / masses[kBar] + 1.0 / masses[kStem]) * d.dot(d);
  const double wanted = -d_rate.dot(d_rate) - (2.0 * baumgarte * g_rate + baumgarte * baumgarte * g);
  return d * (wanted / effective_inverse_mass);
}

inline Contacts findContacts(const BodyVectors& positions) {
  Contacts contacts;
  for (const Body block : {kBar, kStem}) {
    const Eigen::Vector2d d = positions[kPusher] - positions[block];
    const double distance = d.norm();
    const double depth = two_mass::kRadii[kPusher] + two_mass::kRadii[block] - distance;
    if (depth > -two_mass::kContactMargin && distance > two_mass::kCoincident) {
      contacts.add({block, d / distance, depth});
    }
  }
  return contacts;
}

inline void solveContacts(const Contacts& contacts, const BodyScalars& inverse_masses, BodyVectors& velocities) {
  std::array<double, 2> target{};   // normal velocities [m/s]
  std::array<double, 2> impulse{};  // accumulated normal impulses [N s], never negative
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const double approach = std::min(normalVelocity(contacts[i], velocities), 0.0);
    target[i] = -two_mass::kRestitution * approach + (two_mass::kContactBaumgarte / kSubstep) * contacts[i].depth;
  }
  for (int sweep = 0; sweep < two_mass::kContactSweeps; ++sweep) {
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const Contact& contact = contacts[i];
      const double inverse_mass = inverse_masses[kPusher] + inverse_masses[contact.block];
      const double wanted = (target[i] - normalVelocity(contact, velocities)) / inverse_mass;
      const double total = std::max(0.0, impulse[i] + wanted);
      const double change = total - impulse[i];
      impulse[i] = total;
      velocities[kPusher] += (change * inverse_masses[kPusher]) * contact.normal;
      velocities[contact.block] -= (change * inverse_masses[contact.block]) * contact.normal;
    }
  }
}

inline void substep(const TwoMassParameters& parameters, const Eigen::Vector2d& command,
                    two_mass::Bodies<double>& bodies) {
  auto& [positions, velocities] = bodies;
  const BodyScalars masses = {parameters.pusher_mass, kBarMass, kStemMass};
  const BodyScalars inverse_masses = {1.0 / masses[0], 1.0 / masses[1], 1.0 / masses[2]};
  const Eigen::Vector2d link = linkForce(positions, velocities, masses, parameters.baumgarte);
  BodyVectors forces = {Eigen::Vector2d::Zero(), link, -link};
  for (const Body block : {kBar, kStem}) {
    forces[block] -= parameters.block_damp * velocities[block] * masses[block];
  }
  for (const Body block : {kBar, kStem}) {
    velocities[block] += kSubstep * forces[block] * inverse_masses[block];
  }
  velocities[kPusher] += (kSubstep * two_mass::kServoGain) * (command - velocities[kPusher]);
  solveContacts(findContacts(positions), inverse_masses, velocities);
  for (std::size_t body = 0; body < positions.size(); ++body) {
    positions[body] += kSubstep * velocities[body];
  }
}

inline void step(const TwoMassParameters& parameters, const Action& action, two_mass::Bodies<double>& bodies) {
  for (int i = 0; i < kSubstepsPerControlStep; ++i) {
    substep(parameters, {action[0], action[1]}, bodies);
  }
}

}  // namespace pusht::naive
