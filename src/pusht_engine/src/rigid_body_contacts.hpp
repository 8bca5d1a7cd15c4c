// SPDX-License-Identifier: BSD-3-Clause
/// Contacts of the rigid-body engine: between pusher, tee and walls. Units are SI, vectors in the table's frame.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "pusht_engine/rigid_body_model.hpp"
#include "pusht_task/constants.hpp"

namespace pusht::rigid_body {

/// Bodies of a contact. It pushes the first along its normal, the second against it; walls stand still.
enum class Pair { kTeePusher, kTeeWall, kPusherWall };

/// Contact between two bodies.
struct Contact {
  bool touching;           ///< whether they touch; if not, only the depth may be read
  Eigen::Vector2d point;   ///< [m] at which forces act
  Eigen::Vector2d normal;  ///< unit vector along which the contact pushes the body named in the function's comment
  double depth;            ///< [m] overlap; below 0 across a gap
  Pair pair = Pair::kTeePusher;
  double multiplicity = 1.0;  ///< [-] number of equal contacts that this one stands for
};

/// Contacts of a world that touch: of the pusher with two parts of the tee and with four walls, of four corners of two
/// parts with four walls.
struct Contacts {
  static constexpr std::size_t kMost = 2 + 4 + 4 * 2 * 4;

  std::array<Contact, kMost> contacts;  ///< valid are the first `count`
  std::size_t count = 0;

  Contacts() {}  // NOLINT(modernize-use-equals-default): leaves the array as it is
  void add(const Contact& contact, Pair pair, double multiplicity = 1.0);
  const Contact* begin() const { return contacts.data(); }
  const Contact* end() const { return contacts.data() + count; }
};

/// Direction of a body: its x axis in the table's frame is (cosine, sine).
struct Heading {
  double cosine;
  double sine;

  Eigen::Vector2d toTable(const Eigen::Vector2d& v) const {
    return {cosine * v.x() - sine * v.y(), sine * v.x() + cosine * v.y()};
  }
  Eigen::Vector2d toBody(const Eigen::Vector2d& v) const {
    return {cosine * v.x() + sine * v.y(), cosine * v.y() - sine * v.x()};
  }
};

/// Heading of a yaw [rad], from its half angle. MuJoCo, which turns bodies by quaternions, rounds nearly so; last bits
/// decide which portal is found.
Heading headingOf(double yaw);

/// Pose of the tee, as geometry.
struct Tee {
  Eigen::Vector2d origin;  ///< [m] of its coordinates
  Heading heading;
  Eigen::Vector2d center_of_mass;  ///< [m] from the origin
};

/// [m] Center of a part.
Eigen::Vector2d centerOf(const Part& part, const Tee& tee);

/// Contact of two discs; pushes the first. Discs touch if their gap is less than `margin` [m]. Discs with the same
/// center have no normal, and do not touch.
Contact touchDiscs(const Eigen::Vector2d& first, double first_radius, const Eigen::Vector2d& second,
                   double second_radius, double margin);

/// Contact of a disc and a box at their nearest points; pushes the box. A disc whose center is inside the box is pushed
/// out through the nearest of its four faces.
Contact touchNearest(const Eigen::Vector2d& disc, double radius, const Box& box, const Eigen::Vector2d& box_center,
                     const Heading& heading, double margin);

/// Contact of a disc and a wall at their nearest points; pushes the disc.
Contact touchWall(const Eigen::Vector2d& disc, double radius, const Wall& wall, double margin);

/// Contact of pusher and box by MuJoCo's narrow phase, libccd's MPR on a cylinder and a box in space; pushes the box.
/// Touches if libccd finds an overlap. Source: G. Snethen, "XenoCollide: Complex Collision Made Simple" (Game
/// Programming Gems 7, 2008).
Contact touchPortal(const Eigen::Vector2d& pusher, double radius, const Box& box, const Eigen::Vector2d& box_center,
                    const Heading& heading);

/// Replaces a contact of nearest points, which pushes the box, by that of touchPortal. Where libccd finds no overlap,
/// only a contact across a gap (within a margin) stays.
void refine(const Eigen::Vector2d& pusher, double radius, const Box& box, const Eigen::Vector2d& box_center,
            const Heading& heading, Contact& contact);

/// Contact of the pusher and a part of the tee, with the model's shapes and narrow phase; pushes the tee.
Contact touchTee(const Model& model, const Tee& tee, const Eigen::Vector2d& pusher, const Part& part);

/// All contacts of a world that touch. Order: tee and pusher; then wall by wall, the pusher's and the tee's.
Contacts findContacts(const Model& model, const Tee& tee, const Eigen::Vector2d& pusher);

}  // namespace pusht::rigid_body
