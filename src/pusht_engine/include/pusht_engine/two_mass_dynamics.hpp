// SPDX-License-Identifier: BSD-3-Clause
/// Physics of the two-mass engine, one function a law. The number type Real is double for one world, simd::Lanes for
/// several. Units are SI, vectors in the table's frame.
/// Source: chapters 3.3 to 3.6 of the zero2robot course; the order of operations is theirs.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>

#include "pusht_engine/simd.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/types.hpp"

namespace pusht::two_mass {

using simd::any;
using simd::Condition;
using simd::scaled;
using simd::select;
using simd::Vector2;

constexpr double kBarRadius = 0.032;       ///< [m] disc that stands for the bar
constexpr double kStemRadius = 0.026;      ///< [m] disc that stands for the stem
constexpr double kServoGain = 20.0;        ///< [1/s] of the pusher's velocity servo
constexpr double kRestitution = 0.0;       ///< [-] of contacts
constexpr double kContactBaumgarte = 0.2;  ///< [-] share of the overlap removed in one substep
constexpr double kContactMargin = 1.0e-3;  ///< [m] gap below which discs touch
constexpr double kCoincident = 1.0e-12;    ///< [m] distance of centers up to which discs have no normal
constexpr int kContactSweeps = 10;         ///< Gauss-Seidel sweeps

/// Discs of the engine: the pusher and the two masses of the tee.
enum Body : std::size_t { kPusher, kBar, kStem, kBodyCount };
constexpr std::array<Body, 2> kBlocks = {kBar, kStem};  ///< the masses of the tee

constexpr std::array<double, kBodyCount> kRadii = {kPusherRadius, kBarRadius, kStemRadius};  // [m]

template <class Real>
using BodyVectors = std::array<Vector2<Real>, kBodyCount>;
using BodyScalars = std::array<double, kBodyCount>;

/// Contact of the pusher and one mass of the tee.
template <class Real>
struct Contact {
  Body block;  ///< kBar or kStem
  Condition<Real> touching;
  Vector2<Real> normal;  ///< unit vector from the mass to the pusher
  Real depth;            ///< [m] overlap; below 0 across a gap
};

/// Contacts with bar and stem, in this order. Normal and depth are valid where they touch.
template <class Real>
using Contacts = std::array<Contact<Real>, kBlocks.size()>;

/// [rad] in [-pi, pi): yaw of the tee, read from the line bar to stem, which is body -y.
inline double yaw(const Eigen::Vector2d& bar, const Eigen::Vector2d& stem) {
  const Eigen::Vector2d line = stem - bar;
  return wrapAngle(std::atan2(line.y(), line.x()) + kPi / 2.0);
}

/// [N] Force on the bar (the stem gets its opposite) that holds the masses at rest length: a Lagrange multiplier with
/// Baumgarte stabilization of frequency `baumgarte` [rad/s].
template <class Real>
Vector2<Real> linkForce(const BodyVectors<Real>& positions, const BodyVectors<Real>& velocities,
                        const BodyScalars& masses, double baumgarte) {
  const Vector2<Real> d = positions[kBar] - positions[kStem];
  const Vector2<Real> d_rate = velocities[kBar] - velocities[kStem];
  // Constraint g = (d.d - L^2) / 2 with rate d.d_rate; its Jacobian is d on the bar and -d on the stem.
  const Real g = 0.5 * (d.dot(d) - kStemOffset * kStemOffset);
  const Real g_rate = d.dot(d_rate);
  const Real effective_inverse_mass = (1.0 / masses[kBar] + 1.0 / masses[kStem]) * d.dot(d);
  const Real wanted = -d_rate.dot(d_rate) - (2.0 * baumgarte * g_rate + baumgarte * baumgarte * g);
  return scaled<Real>(wanted / effective_inverse_mass, d);
}

/// Contacts of the pusher with both masses of the tee, from positions [m].
template <class Real>
Contacts<Real> findContacts(const BodyVectors<Real>& positions) {
  using std::sqrt;
  Contacts<Real> contacts;
  for (std::size_t i = 0; i < kBlocks.size(); ++i) {
    const Vector2<Real> d = positions[kPusher] - positions[kBlocks[i]];
    const Real distance = sqrt(d.dot(d));
    const Real depth = kRadii[kPusher] + kRadii[kBlocks[i]] - distance;
    contacts[i] = {
        kBlocks[i], depth > -kContactMargin && distance > kCoincident, {d.x() / distance, d.y() / distance}, depth};
  }
  return contacts;
}

/// [m/s] Relative velocity of the pusher along the normal; negative while they approach.
template <class Real>
Real normalVelocity(const Contact<Real>& contact, const BodyVectors<Real>& velocities) {
  return velocities[kPusher].dot(contact.normal) - velocities[contact.block].dot(contact.normal);
}

/// [m/s] Velocity with `change` added where the contact touches.
template <class Real>
Vector2<Real> changedWhereTouching(const Contact<Real>& contact, const Vector2<Real>& velocity,
                                   const Vector2<Real>& change) {
  return {select(contact.touching, velocity.x() + change.x(), velocity.x()),
          select(contact.touching, velocity.y() + change.y(), velocity.y())};
}

/// Changes `velocities` by the contacts' impulses, without friction: projected Gauss-Seidel on accumulated normal
/// impulses.
template <class Real>
void solveContacts(const Contacts<Real>& contacts, const BodyScalars& inverse_masses, BodyVectors<Real>& velocities) {
  const Real zero(0.0);
  if (!any(contacts[0].touching || contacts[1].touching)) {
    return;
  }
  std::array<Real, kBlocks.size()> target;                  // normal velocities [m/s]
  std::array<Real, kBlocks.size()> impulse = {zero, zero};  // accumulated normal impulses [N s], never negative
  for (std::size_t i = 0; i < kBlocks.size(); ++i) {
    const Real velocity = normalVelocity(contacts[i], velocities);
    const Real approach = select(zero < velocity, zero, velocity);
    target[i] = -kRestitution * approach + (kContactBaumgarte / kSubstep) * contacts[i].depth;
  }
  for (int sweep = 0; sweep < kContactSweeps; ++sweep) {
    Condition<Real> changed(false);
    for (std::size_t i = 0; i < kBlocks.size(); ++i) {
      const Contact<Real>& contact = contacts[i];
      if (!any(contact.touching)) {
        continue;
      }
      const Body block = contact.block;
      const double inverse_mass = inverse_masses[kPusher] + inverse_masses[block];
      const Real wanted = (target[i] - normalVelocity(contact, velocities)) / inverse_mass;
      const Real sum = impulse[i] + wanted;
      const Real total = select(zero < sum, sum, zero);
      const Real change = total - impulse[i];
      impulse[i] = total;
      changed = changed || (contact.touching && change != zero);
      const Vector2<Real> push = scaled<Real>(change * inverse_masses[kPusher], contact.normal);
      const Vector2<Real> recoil = scaled<Real>(change * inverse_masses[block], contact.normal);
      velocities[kPusher] = changedWhereTouching(contact, velocities[kPusher], push);
      velocities[block] = changedWhereTouching<Real>(contact, velocities[block], -recoil);
    }
    // After a sweep that changed no impulse the others would change none.
    if (!any(changed)) {
      return;
    }
  }
}

/// State of a world: positions [m] and velocities [m/s] of the masses.
template <class Real>
struct Bodies {
  BodyVectors<Real> positions;
  BodyVectors<Real> velocities;
};

/// Constants of a substep.
struct Model {
  BodyScalars masses;          ///< [kg]
  BodyScalars inverse_masses;  ///< [1/kg]
  double block_damp;           ///< [1/s]
  double baumgarte;            ///< [rad/s]
};

/// One substep in which the pusher is to move with velocity `command` [m/s].
template <class Real>
void substep(const Model& model, const Vector2<Real>& command, Bodies<Real>& bodies) {
  auto& [positions, velocities] = bodies;

  // Forces on the tee: the link between its masses, and drag.
  const Vector2<Real> link = linkForce(positions, velocities, model.masses, model.baumgarte);
  std::array<Vector2<Real>, kBlocks.size()> forces = {link, -link};
  for (std::size_t i = 0; i < kBlocks.size(); ++i) {
    const Body block = kBlocks[i];
    forces[i] -= scaled<Real>(model.masses[block], scaled<Real>(model.block_damp, velocities[block]));
  }

  // Velocities: the tee by its forces, the pusher by its servo.
  for (std::size_t i = 0; i < kBlocks.size(); ++i) {
    const Body block = kBlocks[i];
    velocities[block] += scaled<Real>(model.inverse_masses[block], scaled<Real>(kSubstep, forces[i]));
  }
  velocities[kPusher] += scaled<Real>(kSubstep * kServoGain, command - velocities[kPusher]);

  // Contacts change velocities, velocities change positions (semi-implicit Euler).
  solveContacts(findContacts(positions), model.inverse_masses, velocities);
  for (std::size_t body = 0; body < kBodyCount; ++body) {
    positions[body] += scaled<Real>(kSubstep, velocities[body]);
  }
}

}  // namespace pusht::two_mass
