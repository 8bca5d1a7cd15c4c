// SPDX-License-Identifier: BSD-3-Clause
/// The physics of the two-mass engine, one function a law. Units are SI, vectors in table axes.
/// Source: chapters 3.3 to 3.6 of the zero2robot course; the order of operations is theirs.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace pusht::two_mass {

constexpr double kBarRadius = 0.032;       ///< [m] the disc that stands for the bar
constexpr double kStemRadius = 0.026;      ///< [m] the disc that stands for the stem
constexpr double kServoGain = 20.0;        ///< [1/s] of the pusher's velocity servo
constexpr double kRestitution = 0.0;       ///< [-] of contacts
constexpr double kContactBaumgarte = 0.2;  ///< [-] share of the overlap removed in one substep
constexpr double kContactMargin = 1.0e-3;  ///< [m] discs closer than this touch
constexpr double kCoincident = 1.0e-12;    ///< [m] discs closer than this have no normal
constexpr int kContactSweeps = 10;         ///< Gauss-Seidel sweeps

enum Body : std::size_t { kPusher, kBar, kStem, kBodyCount };

using BodyVectors = std::array<Eigen::Vector2d, kBodyCount>;
using BodyScalars = std::array<double, kBodyCount>;

/// The pusher against one mass of the tee.
struct Contact {
  Body block;              ///< kBar or kStem
  Eigen::Vector2d normal;  ///< from the mass to the pusher, of length 1
  double depth;            ///< [m] overlap; slightly negative inside the margin
};

/// At most one contact per mass of the tee, bar first.
class Contacts {
 public:
  void add(const Contact& contact) { contacts_[size_++] = contact; }
  const Contact* begin() const { return contacts_.data(); }
  const Contact* end() const { return contacts_.data() + size_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const Contact& operator[](std::size_t i) const { return contacts_[i]; }

 private:
  std::array<Contact, 2> contacts_{};
  std::size_t size_ = 0;
};

/// [rad] in [-pi, pi): yaw of the tee, read from the line bar to stem, which is body -y.
double yaw(const Eigen::Vector2d& bar, const Eigen::Vector2d& stem);

/// Force [N] on the bar (the stem gets its opposite) that holds the masses at rest length, as a Lagrange
/// multiplier with Baumgarte stabilisation of frequency `baumgarte` [rad/s].
Eigen::Vector2d linkForce(const BodyVectors& positions, const BodyVectors& velocities, const BodyScalars& masses,
                          double baumgarte);

/// Contacts of the pusher with bar, then stem.
Contacts findContacts(const BodyVectors& positions);

/// Projected Gauss-Seidel on the accumulated normal impulses, frictionless; changes `velocities`.
void solveContacts(const Contacts& contacts, const BodyScalars& inverse_masses, BodyVectors& velocities);

}  // namespace pusht::two_mass
