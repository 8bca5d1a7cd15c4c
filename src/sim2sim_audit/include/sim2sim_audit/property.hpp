// SPDX-License-Identifier: BSD-3-Clause
/// Properties that an audit estimates in a world: what each is, and what its difference means.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace sim2sim {

/// Property of a world. Those up to kLastContractProperty are the contract: a world that differs there has an error,
/// whatever its physics.
enum class Property : std::size_t {
  // Bookkeeping.
  kRefusedStarts,
  kStartPusherPosition,
  kStartPusherVelocity,
  kStartTeePosition,
  kStartTeeVelocity,
  kStartYaw,
  kStartYawRate,
  kFixedPoint,
  kNoise,
  kLeak,
  kSecondWorld,
  kHiddenState,
  kStaleSteps,
  // Frames and units.
  kYawGain,
  kYawOffset,
  kOriginX,
  kOriginY,
  kPusherVelocityFactor,
  kTeeVelocityFactor,
  kTeeVelocityFrame,
  kTeeVelocityPoint,
  kYawRateFactor,
  // Time and actions.
  kControlStep,
  kRestMotion,
  kSpeedGain,
  kDelay,
  kHold,
  kAxesTurn,
  kAxesMirror,
  kActionScaleX,
  kActionScaleY,
  kSmallCommand,
  kActionLimit,
  // Pusher.
  kServoGain,
  kServoLimit,
  kPusherDamping,
  kPusherMass,
  kServoLag,
  kOvershoot,
  kMoveOrder,
  // Tee.
  kTeeMass,
  kCenterOfMass,
  kTeeMoment,
  kTeeDamping,
  kTeeYawDamping,
  kTeeFrictionX,
  kTeeFrictionY,
  kTeeYawFriction,
  kFrictionShape,
  kDampingPoint,
  kFrictionPoint,
  kFrictionSmoothing,
  kTeeLaw,
  // Contacts.
  kOutline,
  kPusherRadius,
  kBarHalfLength,
  kBarHalfWidth,
  kStemEnd,
  kStemHalfWidth,
  kStemPlace,
  kSlop,
  kContactFriction,
  kOverlap,
  kHit,
  // Walls.
  kWallUp,
  kWallDown,
  kWallRight,
  kWallLeft,
  kTeeAtWallUp,
  kTeeAtWallDown,
  kTeeAtWallRight,
  kTeeAtWallLeft,
  kCount
};

constexpr std::size_t kPropertyCount = static_cast<std::size_t>(Property::kCount);
constexpr Property kLastContractProperty = Property::kActionLimit;

/// Area of a property, in the order in which findings are shown.
enum class Area { kBookkeeping, kFrames, kTimeAndAction, kPusher, kTee, kContact, kWalls };

/// Name of an area in files and tables: "frames and units".
const char* nameOf(Area area);

/// How much two values of a property may differ before the difference can be trusted.
struct Resolution {
  double absolute = 0.0;  ///< in the property's unit
  double relative = 0.0;  ///< [-] share of the reference's value
  double felt = 0.0;  ///< difference that moves other properties by what counts there; 0: the least that counts here
};

/// Description of a property.
struct PropertyDescription {
  Property property;
  const char* key;    ///< name in files: "delay"
  const char* title;  ///< for people: "delay of actions"
  const char* unit;   ///< empty: none
  Area area;
  Resolution resolution;
  /// Known only up to a factor that is common to all masses and forces, because no motion depends on it.
  bool mass_like;
  /// [m] Mean divergence after 5 control steps of expert replays, per unit of the difference or, for a mass-like
  /// property, per relative difference: measured by effects_test.cpp where a fault of this property can be planted,
  /// and of its neighbours' size elsewhere.
  double effect;
  const char* look_at;  ///< where to look if it differs
  /// Properties that its experiment takes for granted: a difference in one of them may be what this one shows, as far
  /// as it is large enough (mayFollow() in audit.cpp).
  std::vector<Property> follows_from;
};

/// Description of `property`.
const PropertyDescription& describe(Property property);

/// Descriptions of all properties, in the order of the enumeration.
const std::vector<PropertyDescription>& allProperties();

/// Name of an infinite value of `property`: "none" of a wall or a limit; "unlimited" of a servo that does not yield.
const char* nameOfInfinity(Property property);

/// Whether a difference in `property` is an error of the contract and not another physics.
constexpr bool isContract(Property property) { return property <= kLastContractProperty; }

}  // namespace sim2sim
