// SPDX-License-Identifier: BSD-3-Clause
#include "rigid_body_contacts.hpp"

#include <algorithm>
#include <cmath>

namespace pusht::rigid_body {
namespace {

double sideOf(double value) { return value < 0.0 ? -1.0 : 1.0; }

/// [m] Overlap of a disc and a wall; below 0 across a gap.
double depthAt(const Wall& wall, const Eigen::Vector2d& disc, double radius) {
  return wall.along(disc) + (radius - wall.face);
}

/// Contact of the pusher and a wall, with the model's narrow phase; pushes the pusher.
Contact touchWallByPusher(const Model& model, const Eigen::Vector2d& pusher, const Wall& wall, double margin) {
  Contact contact = touchWall(pusher, model.pusher_radius, wall, margin);
  if (model.switches.narrow_phase && contact.touching) {
    constexpr Heading kStraight = {1.0, 0.0};
    contact.normal = -contact.normal;
    refine(pusher, model.pusher_radius, wall.box(), wall.center(), kStraight, contact);
    contact.normal = -contact.normal;
  }
  return contact;
}

/// Adds the contacts of a part of the tee and a wall: of a disc, or of the box's corners, one by one. MuJoCo finds the
/// edge at each corner twice, at its ends, and half as deep as it is.
void addPartAtWall(const Model& model, const Tee& tee, const Part& part, const Wall& wall, double margin,
                   Contacts& contacts) {
  const Eigen::Vector2d center = centerOf(part, tee);
  if (!(depthAt(wall, center, part.reach()) > -margin)) {
    return;
  }
  if (!model.switches.shape) {
    contacts.add(touchWall(center, part.disc_radius, wall, margin), Pair::kTeeWall);
    return;
  }
  for (const double x : {part.box.half_x, -part.box.half_x}) {
    for (const double y : {part.box.half_y, -part.box.half_y}) {
      Contact contact = touchWall(center + tee.heading.toTable({x, y}), 0.0, wall, margin);
      if (model.switches.narrow_phase) {
        contact.depth *= 0.5;
      }
      contacts.add(contact, Pair::kTeeWall, model.switches.narrow_phase ? 2.0 : 1.0);
    }
  }
}

double marginOf(const Model& model) { return model.switches.softness ? 0.0 : simple::kMargin; }

}  // namespace

void Contacts::add(const Contact& contact, Pair pair, double multiplicity) {
  if (contact.touching) {
    contacts[count] = contact;
    contacts[count].pair = pair;
    contacts[count].multiplicity = multiplicity;
    ++count;
  }
}

Heading headingOf(double yaw) {
  const double cosine = std::cos(0.5 * yaw);
  const double sine = std::sin(0.5 * yaw);
  return {cosine * cosine - sine * sine, 2.0 * cosine * sine};
}

Eigen::Vector2d centerOf(const Part& part, const Tee& tee) {
  return tee.origin + Eigen::Vector2d(part.offset * tee.heading.sine, -part.offset * tee.heading.cosine);
}

Box Wall::box() const {
  const double half_length = face + dynamics::kWallThickness;
  constexpr double kHalfThickness = 0.5 * dynamics::kWallThickness;
  constexpr double kHalfHeight = 0.03;  // [m] in MuJoCo's scene; walls stand on the table
  return {axis == 0 ? kHalfThickness : half_length, axis == 0 ? half_length : kHalfThickness, kHalfHeight, kHalfHeight};
}

Contact touchDiscs(const Eigen::Vector2d& first, double first_radius, const Eigen::Vector2d& second,
                   double second_radius, double margin) {
  constexpr double kCoincident = 1.0e-12;  // [m]
  const Eigen::Vector2d apart = first - second;
  const double distance = std::sqrt(apart.dot(apart));
  const double depth = first_radius + second_radius - distance;
  if (!(distance > kCoincident)) {
    return {false, second, {1.0, 0.0}, depth};
  }
  const Eigen::Vector2d normal = (1.0 / distance) * apart;
  return {depth > -margin, second + (second_radius - 0.5 * depth) * normal, normal, depth};
}

Contact touchNearest(const Eigen::Vector2d& disc, double radius, const Box& box, const Eigen::Vector2d& box_center,
                     const Heading& heading, double margin) {
  const Eigen::Vector2d local = heading.toBody(disc - box_center);
  const Eigen::Vector2d nearest(std::clamp(local.x(), -box.half_x, box.half_x),
                                std::clamp(local.y(), -box.half_y, box.half_y));
  const Eigen::Vector2d apart = local - nearest;
  const double squared = apart.dot(apart);
  Eigen::Vector2d out;              // unit vector from the box to the disc, in the box's axes
  double gap = std::sqrt(squared);  // [m] from the box to the disc's center
  if (squared > 0.0) {              // outside: from the nearest point of the box to the center
    out = (1.0 / gap) * apart;
  } else {  // inside: through the nearest face
    const double room_x = box.half_x - std::abs(local.x());
    const double room_y = box.half_y - std::abs(local.y());
    gap = -std::min(room_y, room_x);
    out = room_x < room_y ? Eigen::Vector2d(sideOf(local.x()), 0.0) : Eigen::Vector2d(0.0, sideOf(local.y()));
  }
  const double depth = radius - gap;
  const Eigen::Vector2d normal = -heading.toTable(out);
  return {depth > -margin, disc + (radius - 0.5 * depth) * normal, normal, depth};
}

Contact touchWall(const Eigen::Vector2d& disc, double radius, const Wall& wall, double margin) {
  const double depth = depthAt(wall, disc, radius);
  const Eigen::Vector2d normal = wall.inward();
  if (!(depth > -margin)) {
    return {false, disc, normal, depth};
  }
  return {true, disc - (radius - 0.5 * depth) * normal, normal, depth};
}

Contact touchTee(const Model& model, const Tee& tee, const Eigen::Vector2d& pusher, const Part& part) {
  const Eigen::Vector2d center = centerOf(part, tee);
  const double margin = marginOf(model);
  if (!model.switches.shape) {
    return touchDiscs(center, part.disc_radius, pusher, model.pusher_radius, margin);
  }
  Contact contact = touchNearest(pusher, model.pusher_radius, part.box, center, tee.heading, margin);
  if (model.switches.narrow_phase) {
    refine(pusher, model.pusher_radius, part.box, center, tee.heading, contact);
  }
  return contact;
}

Contacts findContacts(const Model& model, const Tee& tee, const Eigen::Vector2d& pusher) {
  Contacts contacts;
  for (const Part& part : model.parts) {
    contacts.add(touchTee(model, tee, pusher, part), Pair::kTeePusher);
  }
  if (model.switches.walls) {
    const double margin = marginOf(model);
    for (const Wall& wall : model.walls) {
      contacts.add(touchWallByPusher(model, pusher, wall, margin), Pair::kPusherWall);
      for (const Part& part : model.parts) {
        addPartAtWall(model, tee, part, wall, margin, contacts);
      }
    }
  }
  return contacts;
}

}  // namespace pusht::rigid_body
