// SPDX-License-Identifier: BSD-3-Clause
/// Physics of the rigid-body engine: MuJoCo's of the task's scene, each part of which a switch replaces by the two-mass
/// engine's. Units are SI, vectors in the table's frame.
/// Source of the faithful parts: the chapter "Computation" of MuJoCo's documentation, for the integrator `implicit`.
#pragma once

#include <Eigen/Core>

#include "pusht_engine/rigid_body_model.hpp"
#include "rigid_body_contacts.hpp"
#include "rigid_body_solver.hpp"

namespace pusht::rigid_body {

/// Pose of the tee at these positions.
Tee teeOf(const Model& model, const Vector& positions);

/// [kg, kg m, kg m^2] Inertia of the coordinates.
Matrix massMatrix(const Model& model, const Tee& tee);

/// [N, N m] Forces that are smooth functions of positions and velocities: drag and centrifugal force on the tee, the
/// pusher's servo.
Vector smoothForce(const Model& model, const Tee& tee, const Matrix& mass, const Bodies& bodies,
                   const Eigen::Vector2d& command);

/// Rows of the solver: Coulomb friction with the table, then those of each contact.
Rows constraintsOf(const Model& model, const Tee& tee, const Contacts& contacts, const Vector& velocities);

/// [-] Share of a missing acceleration that a soft contact makes up, by its depth [m]. MuJoCo's `solimp`.
double impedance(double depth);

/// Acceleration of a contact along `direction` (of any length) per acceleration of each coordinate. `arm` [m] goes from
/// the tee's origin to the point of contact.
Vector jacobianAlong(const Eigen::Vector2d& direction, const Eigen::Vector2d& arm, Pair pair);

/// Acceleration of the implicit integrator: solution a of (M - h D) a = `force`, where D is the derivative of the
/// smooth force by the velocities. D keeps the servo's part where its force is at its limit, as MuJoCo's does.
Vector implicitAcceleration(const Model& model, const Tee& tee, const Matrix& mass, const Vector& velocities,
                            const Vector& force);

}  // namespace pusht::rigid_body
