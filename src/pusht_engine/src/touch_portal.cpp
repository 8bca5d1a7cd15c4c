// SPDX-License-Identifier: BSD-3-Clause
#include <ccd/ccd.h>

#include <cmath>

#include "rigid_body_contacts.hpp"

namespace pusht::rigid_body {
namespace {

// MuJoCo's options for convex collisions, and the scene's heights: they decide which portal is found first.
constexpr double kTolerance = 1e-6;         // [m] mpr_tolerance
constexpr int kIterations = 50;             // mpr_iterations
constexpr double kPusherHeight = 0.02;      // [m] of the cylinder's center
constexpr double kPusherHalfHeight = 0.02;  // [m]
constexpr double kNoDirection = 1e-15;

struct Cylinder {
  Eigen::Vector2d center;
  double radius;
};

struct PlacedBox {
  const Box& box;
  Eigen::Vector2d center;
  Heading heading;
};

double signOf(double value) { return value > 0.0 ? 1.0 : (value < 0.0 ? -1.0 : 0.0); }

void centerOfCylinder(const void* object, ccd_vec3_t* center) {
  const auto& cylinder = *static_cast<const Cylinder*>(object);
  ccdVec3Set(center, cylinder.center.x(), cylinder.center.y(), kPusherHeight);
}

void centerOfBox(const void* object, ccd_vec3_t* center) {
  const auto& box = *static_cast<const PlacedBox*>(object);
  ccdVec3Set(center, box.center.x(), box.center.y(), box.box.height);
}

/// The point of the cylinder that is farthest along `direction`.
void supportOfCylinder(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) {
  const auto& cylinder = *static_cast<const Cylinder*>(object);
  const auto [x, y, z] = direction->v;
  const double length = std::sqrt(x * x + y * y);
  const bool slanted = length >= kNoDirection;
  ccdVec3Set(point, (slanted ? x / length * cylinder.radius : 0.0) + cylinder.center.x(),
             (slanted ? y / length * cylinder.radius : 0.0) + cylinder.center.y(),
             signOf(z) * kPusherHalfHeight + kPusherHeight);
}

/// The point of the box that is farthest along `direction`.
void supportOfBox(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) {
  const auto& box = *static_cast<const PlacedBox*>(object);
  const auto [x, y, z] = direction->v;
  const Eigen::Vector2d local = box.heading.toBody({x, y});
  const Eigen::Vector2d corner =
      box.heading.toTable({signOf(local.x()) * box.box.half_x, signOf(local.y()) * box.box.half_y});
  ccdVec3Set(point, corner.x() + box.center.x(), corner.y() + box.center.y(),
             signOf(z) * box.box.half_height + box.box.height);
}

}  // namespace

Contact touchPortal(const Eigen::Vector2d& pusher, double radius, const Box& box, const Eigen::Vector2d& box_center,
                    const Heading& heading) {
  const Cylinder cylinder = {pusher, radius};
  const PlacedBox placed = {box, box_center, heading};
  ccd_t options;
  CCD_INIT(&options);
  options.center1 = centerOfCylinder;
  options.center2 = centerOfBox;
  options.support1 = supportOfCylinder;
  options.support2 = supportOfBox;
  options.mpr_tolerance = kTolerance;
  options.max_iterations = kIterations;
  double depth = 0.0;
  ccd_vec3_t direction;
  ccd_vec3_t position;
  if (ccdMPRPenetration(&cylinder, &placed, &options, &depth, &direction, &position) != 0) {
    return {false, pusher, {1.0, 0.0}, 0.0};
  }
  // MuJoCo puts the normal of a round body where it belongs: from its axis to the point. Right on the axis, any will
  // do.
  const Eigen::Vector2d point(position.v[0], position.v[1]);
  const Eigen::Vector2d from_axis = point - pusher;
  const double length = from_axis.norm();
  return {true, point, length > kNoDirection ? Eigen::Vector2d(from_axis / length) : Eigen::Vector2d(1.0, 0.0), depth};
}

void refine(const Eigen::Vector2d& pusher, double radius, const Box& box, const Eigen::Vector2d& box_center,
            const Heading& heading, Contact& contact) {
  // libccd finds no overlap where there is a gap, so bodies that are clearly apart need not be asked about.
  if (contact.depth > -10.0 * kTolerance) {
    if (const Contact found = touchPortal(pusher, radius, box, box_center, heading); found.touching) {
      contact = found;
      return;
    }
  }
  contact.touching = contact.touching && contact.depth <= 0.0;  // within a margin there is no overlap to be found
}

}  // namespace pusht::rigid_body
