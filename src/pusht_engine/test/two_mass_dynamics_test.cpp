// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/two_mass_dynamics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/golden.hpp"

namespace pusht::two_mass {
namespace {

constexpr double kUnitTolerance = 1e-12;

BodyVectors<double> bodyVectors(const nlohmann::json& rows) {
  return {testing::vector2(rows.at(0)), testing::vector2(rows.at(1)), testing::vector2(rows.at(2))};
}

/// Contacts that touch.
std::vector<Contact<double>> contactsOf(const BodyVectors<double>& positions) {
  std::vector<Contact<double>> touching;
  for (const Contact<double>& contact : findContacts(positions)) {
    if (contact.touching) {
      touching.push_back(contact);
    }
  }
  return touching;
}

BodyScalars inverse(const BodyScalars& masses) { return {1.0 / masses[0], 1.0 / masses[1], 1.0 / masses[2]}; }

TEST(TwoMassDynamics, MatchesTheGoldenUnits) {
  std::size_t contact_count = 0;
  for (const auto& unit : testing::loadGolden("pusht_golden.json", "units")) {
    const BodyVectors<double> q = bodyVectors(unit.at("q"));
    const BodyScalars m = unit.at("m").get<BodyScalars>();
    BodyVectors<double> v = bodyVectors(unit.at("v"));

    constexpr double kBaumgarte = 40.0;
    const Eigen::Vector2d force = linkForce(q, v, m, kBaumgarte);
    const BodyVectors<double> expected_force = bodyVectors(unit.at("link_force"));
    const double scale = std::max(1.0, expected_force[kBar].norm());
    EXPECT_LE((force - expected_force[kBar]).norm(), kUnitTolerance * scale);
    EXPECT_LE((-force - expected_force[kStem]).norm(), kUnitTolerance * scale);

    const auto contacts = contactsOf(q);
    ASSERT_EQ(contacts.size(), unit.at("contacts").size());
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const auto& expected = unit.at("contacts").at(i);
      EXPECT_EQ(contacts[i].block, expected.at("j").get<std::size_t>());
      EXPECT_LE((contacts[i].normal - testing::vector2(expected.at("n"))).norm(), kUnitTolerance);
      EXPECT_NEAR(contacts[i].depth, expected.at("depth").get<double>(), kUnitTolerance);
    }
    contact_count += contacts.size();

    solveContacts(findContacts(q), inverse(m), v);
    const BodyVectors<double> expected_v = bodyVectors(unit.at("v_after_contacts"));
    for (std::size_t body = 0; body < kBodyCount; ++body) {
      EXPECT_LE((v[body] - expected_v[body]).norm(), kUnitTolerance);
    }
  }
  EXPECT_GT(contact_count, 10U) << "the golden units must exercise contacts";
}

/// A random placement with the pusher in touch with at least one mass.
struct Touching {
  BodyVectors<double> q;
  BodyVectors<double> v;

  explicit Touching(std::uint64_t seed) {
    NumpyGenerator random(seed);
    const double angle = random.uniform(-kPi, kPi);
    q[kBar] = {random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)};
    q[kStem] = q[kBar] + kStemOffset * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const Body touched = random.random() < 0.5 ? kBar : kStem;
    const double bearing = random.uniform(-kPi, kPi);
    q[kPusher] = q[touched] + 0.04 * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
    for (auto& velocity : v) {
      velocity = {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)};
    }
  }
};

constexpr BodyScalars kMasses = {4.0, kBarMass, kStemMass};

Eigen::Vector2d momentum(const BodyVectors<double>& v) {
  return kMasses[0] * v[0] + kMasses[1] * v[1] + kMasses[2] * v[2];
}

double angularMomentum(const BodyVectors<double>& q, const BodyVectors<double>& v) {
  double sum = 0.0;
  for (std::size_t body = 0; body < kBodyCount; ++body) {
    sum += kMasses[body] * (q[body].x() * v[body].y() - q[body].y() * v[body].x());
  }
  return sum;
}

TEST(SolveContacts, ConservesLinearAndAngularMomentum) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Touching world(seed);
    const BodyVectors<double> before = world.v;
    const auto contacts = contactsOf(world.q);
    ASSERT_FALSE(contacts.empty());
    solveContacts(findContacts(world.q), inverse(kMasses), world.v);
    EXPECT_LE((momentum(world.v) - momentum(before)).norm(), 1e-12);
    // Impulses act along the line of centers, so they have no moment.
    EXPECT_NEAR(angularMomentum(world.q, world.v), angularMomentum(world.q, before), 1e-12);
  }
}

TEST(SolveContacts, PushesOnly) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Touching world(seed);
    const BodyVectors<double> before = world.v;
    const auto contacts = contactsOf(world.q);
    solveContacts(findContacts(world.q), inverse(kMasses), world.v);
    for (const Contact<double>& contact : contacts) {
      // The impulse on a mass points away from the pusher: against the normal.
      const double impulse =
          -kMasses[contact.block] * (world.v[contact.block] - before[contact.block]).dot(contact.normal);
      EXPECT_GE(impulse, -1e-15);
    }
  }
}

/// One contact has the closed form: the normal velocity ends at the Baumgarte target if it was below.
TEST(SolveContacts, SingleContactReachesItsTarget) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Touching world(seed);
    Contacts<double> one = findContacts(world.q);
    const Contact<double> contact = one[0].touching ? one[0] : one[1];
    one = {contact, contact};
    one[1].touching = false;
    const auto separation = [&] { return (world.v[kPusher] - world.v[one[0].block]).dot(one[0].normal); };
    const double target = kContactBaumgarte / kSubstep * one[0].depth;
    const double before = separation();
    solveContacts(one, inverse(kMasses), world.v);
    EXPECT_NEAR(separation(), std::max(before, target), 1e-12);
  }
}

TEST(FindContacts, HasAMarginAndOrder) {
  BodyVectors<double> q = {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.5, 0.0), Eigen::Vector2d(-0.5, 0.0)};
  const double touching = kPusherRadius + kBarRadius;
  q[kBar].x() = touching + 0.99 * kContactMargin;
  ASSERT_EQ(contactsOf(q).size(), 1U);
  EXPECT_NEAR(contactsOf(q)[0].depth, -0.99 * kContactMargin, 1e-15);
  EXPECT_EQ(contactsOf(q)[0].normal, Eigen::Vector2d(-1.0, 0.0)) << "from the mass to the pusher";
  q[kBar].x() = touching + 1.01 * kContactMargin;
  EXPECT_TRUE(contactsOf(q).empty());
  q[kBar].x() = 0.04;
  q[kStem].x() = -0.04;
  ASSERT_EQ(contactsOf(q).size(), 2U);
  EXPECT_EQ(contactsOf(q)[0].block, kBar);
  q[kBar] = q[kPusher];
  ASSERT_EQ(contactsOf(q).size(), 1U) << "coincident centers have no normal";
}

/// At rest length and without stabilization the force is the centripetal one of a spinning dumbbell.
TEST(LinkForce, IsCentripetalForASpinningDumbbell) {
  constexpr double kRate = 3.0;  // [rad/s]
  BodyVectors<double> q;
  BodyVectors<double> v;
  q[kBar] = {0.0, 0.0};
  q[kStem] = {0.0, -kStemOffset};
  v[kBar] = {0.0, 0.0};
  v[kStem] = {kRate * kStemOffset, 0.0};
  const double reduced_mass = kBarMass * kStemMass / (kBarMass + kStemMass);
  const Eigen::Vector2d force = linkForce(q, v, kMasses, 0.0);
  EXPECT_NEAR(force.y(), -reduced_mass * kRate * kRate * kStemOffset, 1e-15);
  EXPECT_NEAR(force.x(), 0.0, 1e-15);
}

/// The force makes g'' + 2 b g' + b^2 g = 0; checked by finite differences of the free motion it causes.
TEST(LinkForce, MakesTheConstraintACriticallyDampedOscillator) {
  constexpr double kBaumgarte = 40.0;
  BodyVectors<double> q;
  BodyVectors<double> v;
  q[kBar] = {0.01, 0.02};
  q[kStem] = {0.015, -0.045};  // longer than the rest length
  v[kBar] = {0.1, -0.2};
  v[kStem] = {-0.3, 0.15};
  const Eigen::Vector2d force = linkForce(q, v, kMasses, kBaumgarte);
  const auto g = [&](double t) {
    const Eigen::Vector2d bar = q[kBar] + t * v[kBar] + 0.5 * t * t / kBarMass * force;
    const Eigen::Vector2d stem = q[kStem] + t * v[kStem] - 0.5 * t * t / kStemMass * force;
    return 0.5 * ((bar - stem).squaredNorm() - kStemOffset * kStemOffset);
  };
  constexpr double kStep = 1e-5;
  const double rate = (g(kStep) - g(-kStep)) / (2.0 * kStep);
  const double acceleration = (g(kStep) - 2.0 * g(0.0) + g(-kStep)) / (kStep * kStep);
  EXPECT_NEAR(acceleration + 2.0 * kBaumgarte * rate + kBaumgarte * kBaumgarte * g(0.0), 0.0, 1e-4);
}

TEST(Yaw, IsZeroWithTheStemBelowTheBar) {
  EXPECT_NEAR(yaw({0.1, 0.1}, {0.1, 0.04}), 0.0, 1e-15);
  EXPECT_NEAR(yaw({0.1, 0.1}, {0.16, 0.1}), kPi / 2.0, 1e-15);
  EXPECT_NEAR(yaw({0.1, 0.1}, {0.04, 0.1}), -kPi / 2.0, 1e-15);
}

}  // namespace
}  // namespace pusht::two_mass
