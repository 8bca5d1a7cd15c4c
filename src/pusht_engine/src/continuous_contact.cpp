// SPDX-License-Identifier: BSD-3-Clause
#include "continuous_contact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pusht::rigid_body {
namespace {

/// Poses of a world.
struct Poses {
  Tee tee;
  Eigen::Vector2d pusher;

  Poses(const Model& model, const Vector& positions)
      : tee(teeOf(model, positions)), pusher(positions[kPusherX], positions[kPusherY]) {}
};

/// Bodies that close a gap of at least 0 [m] within the substep.
struct Closing {
  Pair pair;
  Eigen::Vector2d normal;  ///< as that of a Contact
  Eigen::Vector2d arm;     ///< [m] from the tee's origin to the point of contact
  double gap;
  double excess;  ///< [m] overlap at the end above that at the start, or above the allowed one if that is more
};

/// Share of a whole path at which a disc meets the circle of `reach` around `corner`, coming from outside.
std::optional<double> meetingWithCircle(const Eigen::Vector2d& start, const Eigen::Vector2d& path,
                                        const Eigen::Vector2d& corner, double reach) {
  const Eigen::Vector2d from = start - corner;
  const double a = path.squaredNorm();
  const double b = from.dot(path);
  const double discriminant = b * b - a * (from.squaredNorm() - reach * reach);
  if (!(b < 0.0) || !(discriminant >= 0.0)) {
    return std::nullopt;
  }
  return (-b - std::sqrt(discriminant)) / a;
}

constexpr double kPrecision = 1e-7;  // [m] of overlaps; a hard contact gives way by a millionth of a path
constexpr int kMostSweeps = 30;

/// Speculative contacts of one substep. Each pair has at most one.
class Speculation {
 public:
  Speculation(const Model& model, const Matrix& mass, const Bodies& bodies)
      : model_(model),
        bodies_(bodies),
        start_(model, bodies.positions),
        inertia_(mass),
        overlap_(allowedOverlap(model)) {
    row_of_.fill(kNone);
    const std::array damping = {model.tee_damping, model.tee_damping, model.tee_yaw_damping, model.servo_derivative,
                                model.servo_derivative};
    for (std::size_t i = 0; i < kCoordinateCount; ++i) {
      inertia_[i][i] += model.substep * damping[i];
    }
  }

  /// Adds contacts for what this acceleration makes meet, and tightens those that a turn takes deeper than a straight
  /// path would; whether there was anything to do.
  bool sweep(const Vector& acceleration) {
    Vector positions = bodies_.positions;
    for (std::size_t i = 0; i < kCoordinateCount; ++i) {
      positions[i] += model_.substep * (bodies_.velocities[i] + model_.substep * acceleration[i]);
    }
    const Poses end(model_, positions);
    next_ = 0;
    changed_ = false;
    for (const Part& part : model_.parts) {
      add(pusherAtPart(part, end));
    }
    if (model_.switches.walls) {
      for (const Wall& wall : model_.walls) {
        add(atWall(wall, start_.pusher, end.pusher, model_.pusher_radius, Pair::kPusherWall));
        for (const Part& part : model_.parts) {
          addPartAtWall(part, wall, end);
        }
      }
    }
    return changed_;
  }

  /// The accelerations nearest to this one that keep to all contacts.
  Vector heldBack(const Vector& acceleration) const {
    Vector force = product(inertia_, acceleration);
    const Vector constraint = constraintForce(inertia_, force, rows_);
    for (std::size_t i = 0; i < kCoordinateCount; ++i) {
      force[i] += constraint[i];
    }
    return solved(inertia_, force);
  }

 private:
  std::optional<Closing> pusherAtPart(const Part& part, const Poses& end) const {
    const bool shaped = model_.switches.shape;
    const auto place = [&part](const Poses& poses) {
      return Eigen::Vector2d(poses.tee.heading.toBody(poses.pusher - centerOf(part, poses.tee)));
    };
    const double radius = model_.pusher_radius + (shaped ? 0.0 : part.disc_radius);
    const Eigen::Vector2d half = shaped ? Eigen::Vector2d(part.box.half_x, part.box.half_y) : Eigen::Vector2d(0.0, 0.0);
    const auto hit = sweepDisc(place(start_), place(end), radius - overlap_, half);
    if (!hit) {
      return std::nullopt;
    }
    const auto depth = [&](const Poses& poses) {
      return touchNearest(place(poses), radius, {half.x(), half.y(), 0.0, 0.0}, {0.0, 0.0}, {1.0, 0.0}, 0.0).depth;
    };
    const Eigen::Vector2d point = hit->center - model_.pusher_radius * hit->normal;  // on the tee, in the part's axes
    return Closing{Pair::kTeePusher, -start_.tee.heading.toTable(hit->normal),
                   centerOf(part, start_.tee) + start_.tee.heading.toTable(point) - start_.tee.origin, hit->distance,
                   depth(end) - std::max(overlap_, depth(start_))};
  }

  std::optional<Closing> atWall(const Wall& wall, const Eigen::Vector2d& start, const Eigen::Vector2d& end,
                                double radius, Pair pair) const {
    const auto gap = [&](const Eigen::Vector2d& disc) { return wall.face - radius + overlap_ - wall.along(disc); };
    if (!(gap(end) < std::min(0.0, gap(start)))) {
      return std::nullopt;
    }
    return Closing{pair, wall.inward(), start - start_.tee.origin, std::max(0.0, gap(start)),
                   std::min(0.0, gap(start)) - gap(end)};
  }

  void addPartAtWall(const Part& part, const Wall& wall, const Poses& end) {
    const auto at = [&part](const Tee& tee, const Eigen::Vector2d& point) {
      return Eigen::Vector2d(centerOf(part, tee) + tee.heading.toTable(point));
    };
    const auto touch = [&](const Eigen::Vector2d& point, double radius) {
      add(atWall(wall, at(start_.tee, point), at(end.tee, point), radius, Pair::kTeeWall));
    };
    if (!model_.switches.shape) {
      touch({0.0, 0.0}, part.disc_radius);
      return;
    }
    for (const double x : {part.box.half_x, -part.box.half_x}) {
      for (const double y : {part.box.half_y, -part.box.half_y}) {
        touch({x, y}, 0.0);
      }
    }
  }

  /// Adds or tightens the contact of the next pair, which has this one's place in every sweep.
  void add(const std::optional<Closing>& closing) {
    std::size_t& row = row_of_[next_++];
    if (!closing) {
      return;
    }
    const double h = model_.substep;
    const std::size_t rows = model_.switches.friction ? 3 : 1;
    if (row != kNone) {
      if (closing->excess > kPrecision) {
        for (std::size_t i = 0; i < rows; ++i) {
          rows_.rows[row + i].wanted += closing->excess / (h * h);
        }
        changed_ = true;
      }
      return;
    }
    row = rows_.count;
    changed_ = true;
    const auto add_row = [&](const Eigen::Vector2d& direction) {
      const Vector jacobian = jacobianAlong(direction, closing->arm, closing->pair);
      const double inverse_inertia = dot(jacobian, solved(inertia_, jacobian));
      constexpr double kHardness = (1.0 - simple::kCompliance) / simple::kCompliance;
      rows_.add({jacobian, -(closing->gap / h + dot(jacobian, bodies_.velocities)) / h, kHardness / inverse_inertia,
                 0.0, std::numeric_limits<double>::infinity()});
    };
    add_row(closing->normal);
    if (model_.switches.friction) {
      const double mu = model_.contact_friction;
      const Eigen::Vector2d slanted(-mu * closing->normal.y(), mu * closing->normal.x());
      add_row(closing->normal + slanted);
      add_row(closing->normal - slanted);
    }
  }

  static constexpr std::size_t kNone = Rows::kMost;

  const Model& model_;
  const Bodies& bodies_;
  Poses start_;
  Matrix inertia_;  // of the implicit integrator, but for what turning alone adds
  double overlap_;  // [m]
  Rows rows_;
  std::array<std::size_t, Contacts::kMost> row_of_;  // of each pair
  std::size_t next_ = 0;
  bool changed_ = false;
};

}  // namespace

std::optional<Hit> sweepDisc(const Eigen::Vector2d& start, const Eigen::Vector2d& end, double radius,
                             const Eigen::Vector2d& half) {
  const Eigen::Vector2d path = end - start;
  const Box box = {half.x(), half.y(), 0.0, 0.0};
  const Contact now = touchNearest(start, radius, box, {0.0, 0.0}, {1.0, 0.0}, 0.0);
  if (now.touching) {
    const Eigen::Vector2d out = -now.normal;
    return out.dot(path) < 0.0 ? std::optional<Hit>({0.0, out, start}) : std::nullopt;
  }

  double first = std::numeric_limits<double>::infinity();  // share of the path
  Eigen::Vector2d normal(0.0, 0.0);
  const auto meet = [&](double share, const Eigen::Vector2d& from_box) {
    if (share >= 0.0 && share <= 1.0 && share < first) {
      first = share;
      normal = from_box;
    }
  };
  for (const Eigen::Index axis : {0, 1}) {
    const Eigen::Index other = 1 - axis;
    const double side = path[axis] < 0.0 ? 1.0 : -1.0;  // of the face that the disc moves to
    const double share = (side * (half[axis] + radius) - start[axis]) / path[axis];
    if (std::abs(start[other] + share * path[other]) <= half[other]) {
      meet(share, side * Eigen::Vector2d::Unit(axis));
    }
  }
  for (const double x : {half.x(), -half.x()}) {
    for (const double y : {half.y(), -half.y()}) {
      const Eigen::Vector2d corner(x, y);
      if (const auto share = meetingWithCircle(start, path, corner, radius)) {
        meet(*share, (start + *share * path - corner) / radius);
      }
    }
  }
  if (!(first <= 1.0)) {
    return std::nullopt;
  }
  return Hit{-first * normal.dot(path), normal, start + first * path};
}

double allowedOverlap(const Model& model) { return model.switches.softness ? soft::kWidth : 0.0; }

Vector withoutOverlap(const Model& model, const Matrix& mass, const Bodies& bodies, const Vector& acceleration) {
  Speculation contacts(model, mass, bodies);
  Vector result = acceleration;
  for (int i = 0; i < kMostSweeps && contacts.sweep(result); ++i) {
    result = contacts.heldBack(acceleration);
  }
  return result;
}

}  // namespace pusht::rigid_body
