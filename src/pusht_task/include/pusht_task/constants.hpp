// SPDX-License-Identifier: BSD-3-Clause
/// The numbers that define PushT, each once. Units are SI (m, rad, s, kg); frame: table.
/// Source, unless a line says otherwise: the PushT environment of the zero2robot course.
#pragma once

#include <cstdint>

namespace pusht {

constexpr double kPi = 3.14159265358979323846;

// Time: an action is held for ten substeps.
constexpr double kControlStep = 0.1;  ///< [s]
constexpr double kSubstep = 0.01;     ///< [s]
constexpr int kSubstepsPerControlStep = 10;
constexpr int kHorizon = 300;  ///< control steps after which an episode ends

// Actions: commanded pusher velocity.
constexpr float kActionLimit = 1.0F;  ///< [m/s] per axis

// Success: this many consecutive control steps in tolerance of the target pose (0, 0, 0).
constexpr double kPositionTolerance = 0.03;  ///< [m]
constexpr double kAngleTolerance = 0.20;     ///< [rad]
constexpr int kSuccessHold = 5;              ///< control steps

// Reward: -1/2 (position error / scale + angle error / pi), and a bonus when success latches.
constexpr double kRewardPositionScale = 0.5;  ///< [m]
constexpr double kRewardBonus = 1.0;

// Spawn: the tee on a ring around the target, the pusher anywhere clear of it.
/// Episode i of a run starts from the spawn seed kFirstSpawnSeed + seed of the run + i: policies train on those below.
constexpr std::uint64_t kFirstSpawnSeed = 10'000;
constexpr double kSpawnRadiusMin = 0.10;        ///< [m]
constexpr double kSpawnRadiusMax = 0.24;        ///< [m]
constexpr double kSpawnPusherBound = 0.32;      ///< [m] per axis
constexpr double kSpawnPusherClearance = 0.13;  ///< [m] from the tee origin

// Bodies. The tee is a bar, centered on the tee origin, and a stem below it (body frame: stem along -y).
constexpr double kPusherRadius = 0.015;    ///< [m]
constexpr double kBarHalfLength = 0.06;    ///< [m] along body x
constexpr double kStemHalfLength = 0.045;  ///< [m] along body y
constexpr double kTeeHalfWidth = 0.015;    ///< [m] the other half-size of bar and stem, and their half-height
constexpr double kStemOffset = 0.06;       ///< [m] from the bar's center to the stem's, along body -y
constexpr double kBarMass = 0.06;          ///< [kg]
constexpr double kStemMass = 0.045;        ///< [kg]
/// [m] from the tee origin to its center of mass, along body -y.
constexpr double kCenterOfMassOffset = kStemOffset * kStemMass / (kBarMass + kStemMass);

constexpr double kWallInnerFace = 0.39;  ///< [m] |x| or |y| of the walls' inner faces

/// Dynamics of the reference's scene, for engines that follow it. Damping and friction of the table act on the tee at
/// its origin, along each axis of the table, and on its yaw.
namespace dynamics {
constexpr double kPusherMass = 0.2;        ///< [kg]
constexpr double kServoGain = 20.0;        ///< [N s/m] of the pusher's velocity servo, per axis
constexpr double kServoLimit = 30.0;       ///< [N] per axis
constexpr double kPusherDamping = 0.5;     ///< [N s/m] per axis
constexpr double kTeeDamping = 4.0;        ///< [N s/m] per axis
constexpr double kTeeYawDamping = 0.02;    ///< [N m s]
constexpr double kTeeFriction = 1.2;       ///< [N] Coulomb, per axis
constexpr double kTeeYawFriction = 0.006;  ///< [N m] Coulomb
constexpr double kContactFriction = 1.0;   ///< [-] between all bodies
constexpr double kWallThickness = 0.04;    ///< [m]
}  // namespace dynamics

// Trust in a simulator, ours or foreign.
/// Maximum deviation of the state after a reset from the requested state [m, rad, m/s, rad/s]; it allows for engines in
/// single precision. A kind may declare a smaller one (SimulatorKind::start_tolerance), never a greater.
constexpr double kStartTolerance = 1e-6;
// Plausible range of states. A state beyond it is a failed simulation: the table is 0.78 m wide, and the pusher of a
// world without walls gets 30 m away in an episode.
constexpr double kPlausibleDistance = 1000.0;    ///< [m] per axis
constexpr double kPlausibleSpeed = 100000.0;     ///< [m/s] per axis
constexpr double kPlausibleYawRate = 1000000.0;  ///< [rad/s]

// Frames above the table: the middles of the bodies.
constexpr double kTeeFrameHeight = 0.015;    ///< [m]
constexpr double kPusherFrameHeight = 0.02;  ///< [m]

}  // namespace pusht
