// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/two_mass_dynamics.hpp"

#include <algorithm>
#include <cmath>

#include "pusht_task/constants.hpp"
#include "pusht_task/types.hpp"

namespace pusht::two_mass {
namespace {

constexpr BodyScalars kRadii = {kPusherRadius, kBarRadius, kStemRadius};

/// Relative velocity [m/s] of the pusher along the normal; negative while they approach.
double normalVelocity(const Contact& contact, const BodyVectors& velocities) {
  return velocities[kPusher].dot(contact.normal) - velocities[contact.block].dot(contact.normal);
}

}  // namespace

double yaw(const Eigen::Vector2d& bar, const Eigen::Vector2d& stem) {
  const Eigen::Vector2d line = stem - bar;
  return wrapAngle(std::atan2(line.y(), line.x()) + kPi / 2.0);
}

Eigen::Vector2d linkForce(const BodyVectors& positions, const BodyVectors& velocities, const BodyScalars& masses,
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

Contacts findContacts(const BodyVectors& positions) {
  Contacts contacts;
  for (const Body block : {kBar, kStem}) {
    const Eigen::Vector2d d = positions[kPusher] - positions[block];
    const double distance = d.norm();
    const double depth = kRadii[kPusher] + kRadii[block] - distance;
    if (depth > -kContactMargin && distance > kCoincident) {
      contacts.add({block, d / distance, depth});
    }
  }
  return contacts;
}

void solveContacts(const Contacts& contacts, const BodyScalars& inverse_masses, BodyVectors& velocities) {
  std::array<double, 2> target{};   // normal velocities [m/s]
  std::array<double, 2> impulse{};  // accumulated normal impulses [N s], never negative
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const double approach = std::min(normalVelocity(contacts[i], velocities), 0.0);
    target[i] = -kRestitution * approach + (kContactBaumgarte / kSubstep) * contacts[i].depth;
  }
  for (int sweep = 0; sweep < kContactSweeps; ++sweep) {
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

}  // namespace pusht::two_mass
