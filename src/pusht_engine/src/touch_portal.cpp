// SPDX-License-Identifier: BSD-3-Clause
#include <ccd/ccd.h>

#include <cmath>

#include "pusht_engine/rigid_body_contacts.hpp"

namespace pusht::rigid_body {
namespace {

// MuJoCo's options for convex collisions, and the scene's heights: they decide which portal is found first.
constexpr double kTolerance = 1e-6;         // [m] mpr_tolerance
constexpr int kIterations = 50;             // mpr_iterations
constexpr double kPusherHeight = 0.02;      // [m] of the cylinder's centre
constexpr double kPusherHalfHeight = 0.02;  // [m]
constexpr double kNoDirection = 1e-15;

struct Cylinder {
  Vector2<double> centre;
};

struct PlacedBox {
  const Box& box;
  Vector2<double> centre;
  Heading<double> heading;
};

double signOf(double value) { return value > 0.0 ? 1.0 : (value < 0.0 ? -1.0 : 0.0); }

void centreOfCylinder(const void* object, ccd_vec3_t* centre) {
  const auto& cylinder = *static_cast<const Cylinder*>(object);
  ccdVec3Set(centre, cylinder.centre.x(), cylinder.centre.y(), kPusherHeight);
}

void centreOfBox(const void* object, ccd_vec3_t* centre) {
  const auto& box = *static_cast<const PlacedBox*>(object);
  ccdVec3Set(centre, box.centre.x(), box.centre.y(), box.box.height);
}

/// The point of the cylinder that is farthest along `direction`.
void supportOfCylinder(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) {
  const auto& cylinder = *static_cast<const Cylinder*>(object);
  const auto [x, y, z] = direction->v;
  const double length = std::sqrt(x * x + y * y);
  const bool slanted = length >= kNoDirection;
  ccdVec3Set(point, (slanted ? x / length * kPusherRadius : 0.0) + cylinder.centre.x(),
             (slanted ? y / length * kPusherRadius : 0.0) + cylinder.centre.y(),
             signOf(z) * kPusherHalfHeight + kPusherHeight);
}

/// The same of the box.
void supportOfBox(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) {
  const auto& box = *static_cast<const PlacedBox*>(object);
  const auto [x, y, z] = direction->v;
  const Vector2<double> local = box.heading.toBody({x, y});
  const Vector2<double> corner =
      box.heading.toTable({signOf(local.x()) * box.box.half_x, signOf(local.y()) * box.box.half_y});
  ccdVec3Set(point, corner.x() + box.centre.x(), corner.y() + box.centre.y(),
             signOf(z) * box.box.half_height + box.box.height);
}

}  // namespace

Contact<double> touchPortal(const Vector2<double>& pusher, const Box& box, const Vector2<double>& box_centre,
                            const Heading<double>& heading) {
  const Cylinder cylinder = {pusher};
  const PlacedBox placed = {box, box_centre, heading};
  ccd_t options;
  CCD_INIT(&options);
  options.center1 = centreOfCylinder;
  options.center2 = centreOfBox;
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
  const Vector2<double> point(position.v[0], position.v[1]);
  const Vector2<double> from_axis = point - pusher;
  const double length = from_axis.norm();
  return {true, point, length > kNoDirection ? Vector2<double>(from_axis / length) : Vector2<double>(1.0, 0.0), depth};
}

void refine(const Vector2<double>& pusher, const Box& box, const Vector2<double>& box_centre,
            const Heading<double>& heading, Contact<double>& contact) {
  // libccd finds no overlap where there is a gap, so bodies that are clearly apart need not be asked about.
  if (contact.depth > -10.0 * kTolerance) {
    if (const Contact<double> found = touchPortal(pusher, box, box_centre, heading); found.touching) {
      contact = found;
      return;
    }
  }
  contact.touching = contact.touching && contact.depth <= 0.0;  // within a margin there is no overlap to be found
}

void refine(const Vector2<simd::Lanes>& pusher, const Box& box, const Vector2<simd::Lanes>& box_centre,
            const Heading<simd::Lanes>& heading, Contact<simd::Lanes>& contact) {
  for (int lane = 0; lane < simd::kLaneCount; ++lane) {
    const auto vector = [lane](const Vector2<simd::Lanes>& v) { return Vector2<double>(v.x()[lane], v.y()[lane]); };
    Contact<double> one = {contact.touching[lane], vector(contact.point), vector(contact.normal), contact.depth[lane]};
    refine(vector(pusher), box, vector(box_centre), {heading.cosine[lane], heading.sine[lane]}, one);
    contact.touching[lane] = one.touching;
    contact.depth[lane] = one.depth;
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      contact.point[axis][lane] = one.point[axis];
      contact.normal[axis][lane] = one.normal[axis];
    }
  }
}

}  // namespace pusht::rigid_body
