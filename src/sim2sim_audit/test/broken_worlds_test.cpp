// SPDX-License-Identifier: BSD-3-Clause
// Worlds that fail: an experiment says so, and the others go on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "experiments.hpp"
#include "planted_faults.hpp"
#include "pusht_engine/rigid_body_engine.hpp"
#include "pusht_task/error.hpp"
#include "sim2sim_audit/audit.hpp"
#include "sim2sim_audit/audit_json.hpp"

namespace sim2sim::testing {
namespace {

using pusht::WorldState;

/// A good world until `breaks` says of a start that it is to fail.
class Brittle : public pusht::Simulator {
 public:
  using Breaks = bool (*)(const WorldState& start);
  using Failure = void (*)(WorldState& state);

  Brittle(Breaks breaks, Failure at_reset, Failure at_step)
      : Simulator("brittle", pusht::RigidBodyPhysics::kStartTolerance),
        breaks_(breaks),
        at_reset_(at_reset),
        at_step_(at_step) {}

 private:
  void doReset(const WorldState& state) override {
    inner_.reset(state);
    state_ = inner_.state();
    broken_ = breaks_(state);
    if (broken_) {
      at_reset_(state_);
    }
  }
  void doStep(const pusht::Action& action) override {
    inner_.step(action);
    state_ = inner_.state();
    if (broken_) {
      at_step_(state_);
    }
  }
  WorldState doState() const override { return state_; }

  pusht::RigidBodyEngine inner_;
  Breaks breaks_;
  Failure at_reset_;
  Failure at_step_;
  WorldState state_;
  bool broken_ = false;
};

void doNothing(WorldState& /*state*/) {}
void answerNan(WorldState& state) { state.tee_position.x() = std::numeric_limits<double>::quiet_NaN(); }
void die(WorldState& /*state*/) { throw pusht::RuntimeFault("the node has died"); }
void startElsewhere(WorldState& state) { state.tee_position.x() += 0.01; }

/// Tees that slide fast, as in the experiments of the free tee and the starts.
bool isFast(const WorldState& start) { return start.tee_velocity.norm() > 2.0; }

Audit auditOf(Brittle::Failure at_reset, Brittle::Failure at_step) {
  const WorldFactory good = cleanRigidBody();
  const WorldFactory brittle = [=] { return std::make_unique<Brittle>(isFast, at_reset, at_step); };
  return audit({"good", good}, {"brittle", brittle}, {}, 0, 1);
}

const Comparison& of(const Audit& audit, Property property) {
  return audit.comparisons.at(static_cast<std::size_t>(property));
}

TEST(BrokenWorlds, OneThatAnswersNanSaysSoAndTheOthersGoOn) {
  const Audit result = auditOf(doNothing, answerNan);
  EXPECT_EQ(of(result, Property::kTeeMass).verdict, PropertyVerdict::kCannotTell);
  EXPECT_THAT(of(result, Property::kTeeMass).reason, ::testing::HasSubstr("finite numbers"));
  EXPECT_EQ(of(result, Property::kDelay).verdict, PropertyVerdict::kSame);
  EXPECT_EQ(of(result, Property::kPusherRadius).verdict, PropertyVerdict::kSame);
}

TEST(BrokenWorlds, OneThatDiesSaysSoAndTheOthersGoOn) {
  const Audit result = auditOf(doNothing, die);
  EXPECT_THAT(of(result, Property::kTeeMass).reason, ::testing::HasSubstr("the node has died"));
  EXPECT_EQ(of(result, Property::kContactFriction).verdict, PropertyVerdict::kSame);
}

TEST(BrokenWorlds, OneThatRefusesStartsIsFoundOut) {
  const Audit result = auditOf(startElsewhere, doNothing);
  EXPECT_EQ(of(result, Property::kRefusedStarts).verdict, PropertyVerdict::kDiffers);
  EXPECT_TRUE(result.hasContractErrors());
}

TEST(Audit, HasTheSameBytesOnOneAndTwoThreads) {
  const auto bytes = [](int threads) {
    const AuditedWorld reference = {"rigid body", cleanRigidBody()};
    const AuditedWorld engine = {"Chipmunk", cleanChipmunk()};
    const Audit result = audit(reference, engine, {{"variant", cleanRigidBody()}}, 3, threads);
    return toJson(result).dump() + textOf(result);
  };
  EXPECT_EQ(bytes(1), bytes(2));
}

}  // namespace
}  // namespace sim2sim::testing
