// SPDX-License-Identifier: BSD-3-Clause
// What the contract suites cannot reach over a node: simulations that fail, and policies with a memory.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "pusht_task/clipped.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"
#include "sim2sim_serving/conversions.hpp"
#include "sim2sim_serving/policy_session.hpp"
#include "sim2sim_serving/remote_simulator.hpp"
#include "sim2sim_serving/simulator_session.hpp"

namespace pusht {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// World that notes the seeds of its draws.
class Drawn : public Simulator {
 public:
  Drawn(std::vector<std::uint64_t>& seeds, const Task& task) : Simulator("", 1e-12, task), seeds_(seeds) {}

 private:
  void doReset(const WorldState& state) override { state_ = state; }
  void doSpawn(const WorldState& start, std::uint64_t seed) override {
    seeds_.push_back(seed);
    state_ = start;
  }
  void doStep(const Action& /*action*/) override {}
  WorldState doState() const override { return state_; }

  std::vector<std::uint64_t>& seeds_;
  WorldState state_;
};

/// The pusher goes where it is told; after `steps_to_failure` steps since the start the simulation fails.
class Brittle : public Simulator {
 public:
  explicit Brittle(int steps_to_failure, const Task& task = fullCircle())
      : Simulator("", 1e-12, task), steps_to_failure_(steps_to_failure) {}

 private:
  void doReset(const WorldState& state) override {
    state_ = state;
    steps_ = 0;
  }
  void doStep(const Action& action) override {
    if (++steps_ > steps_to_failure_) {
      throw RuntimeFault("broken on purpose");
    }
    state_.pusher_position += 0.1 * Eigen::Vector2d(action[0], action[1]);
  }
  WorldState doState() const override { return state_; }

  int steps_to_failure_;
  int steps_ = 0;
  WorldState state_;
};

class SimulatorSessions : public ::testing::Test {
 protected:
  SimulatorSessions()
      : session_(kind(), kind().defaults(), "brittle", [this](const auto& update) { seen_.push_back(update); }),
        served_(&session_) {}

  static SimulatorKind kind() {
    SimulatorKind kind;
    kind.name = "brittle";
    kind.title = "something brittle";
    kind.version = "1";
    kind.parameters = {{"steps", "", "until it breaks", std::int64_t{2}, 0, 10, "no test is that patient"}};
    kind.start_tolerance = 1e-12;
    kind.loader = [](const ParameterSet& parameters) {
      SimulatorModel model;
      model.parameters = parameters;
      const auto steps = static_cast<int>(parameters.get<std::int64_t>("steps"));
      model.make_world = [steps] { return std::make_unique<Brittle>(steps); };
      return model;
    };
    return kind;
  }

  pusht_msgs::ResetResponse reset(std::uint64_t episode = 0, const ros::Time& stamp = {}) {
    pusht_msgs::ResetRequest request;
    request.episode = episode;
    request.stamp = stamp;
    return served_->reset(request);
  }
  pusht_msgs::StepResponse step(std::int32_t index, const ros::Time& stamp = {}) {
    pusht_msgs::StepRequest request;
    request.step = index;
    request.action = {1.0F, 0.0F};
    request.stamp = stamp;
    return served_->step(request);
  }
  pusht_msgs::ConfigureResponse configure(const std::string& kind, const Parameters& changes = {}) {
    pusht_msgs::ConfigureRequest request;
    request.kind = kind;
    request.parameters = changes;
    request.end_episode = 1;
    return served_->configure(request);
  }
  pusht_msgs::DescribeResponse describe(const std::string& kind) const {
    pusht_msgs::DescribeRequest request;
    request.kind = kind;
    return served_->describe(request);
  }

  std::vector<pusht_msgs::WorldStateStamped> seen_;
  SimulatorSession session_;
  SimulatorSession* served_;  // the one that is asked
};

TEST_F(SimulatorSessions, DescribesItsKind) {
  const auto description = session_.describe();
  EXPECT_EQ(description.name, "brittle");
  EXPECT_EQ(description.title, "something brittle");
  EXPECT_EQ(description.start_tolerance, 1e-12);
  ASSERT_THAT(description.parameter_descriptors, SizeIs(1));
  const auto& steps = description.parameter_descriptors[0];
  EXPECT_EQ(steps.name, "steps");
  EXPECT_EQ(steps.type, "integer");
  EXPECT_EQ(steps.meaning, "until it breaks");
  EXPECT_EQ(steps.default_value, "2");
  EXPECT_EQ(steps.greatest, 10.0);
}

/// On the caller's side a world starts as near as its node says.
TEST_F(SimulatorSessions, ToldOfByTheStartTolerance) {
  pusht_msgs::DescribeResponse description = session_.describe();
  EXPECT_EQ(startToleranceOf(description), 1e-12);
  description.start_tolerance = 0.0;
  EXPECT_EQ(startToleranceOf(description), kStartTolerance) << "of a node that does not say";
  for (const double bad : {-1e-12, 0.1, kNan}) {
    description.start_tolerance = bad;
    EXPECT_THROW(startToleranceOf(description), BadDependency) << bad;
  }
}

/// The course's task is not told of, as nodes never did; another one is, and decides starts, steps and hash.
TEST_F(SimulatorSessions, TakeATaskAndGiveItBack) {
  SimulatorKind any = kind();
  any.tasks.clear();
  any.loader = [](const ParameterSet& parameters, const Task& task) {
    SimulatorModel model;
    model.parameters = ParameterSet({parameters.at("steps").descriptor});  // its own parameters alone
    model.make_world = [&task] { return std::make_unique<Brittle>(2, task); };
    return model;
  };
  SimulatorSession session(any, withTask(any), "any", [](const auto&) {});
  served_ = &session;
  const auto before = session.describe();
  EXPECT_THAT(before.parameters, SizeIs(1));

  const auto configured = configure("", {parameter("task", "gym_pusht")});
  EXPECT_EQ(configured.message, "");
  EXPECT_EQ(configured.parameters.back(), parameter("task", "gym_pusht"));
  const auto described = session.describe();
  EXPECT_NE(described.parameters_hash, before.parameters_hash);
  EXPECT_EQ(described.parameter_descriptors.back().default_value, "full_circle");
  pusht_msgs::ResetRequest request;
  request.seed = 100'007;
  const auto begun = session.reset(request);
  EXPECT_EQ(fromMessage(begun.state), spawn(100'007, gymPusht()));
  pusht_msgs::StepRequest push;
  push.action = {300.0F, 200.0F};
  EXPECT_NEAR(session.step(push).state.pusher_x - begun.state.pusher_x, 30.0, 1e-4) << "which is not clipped";

  EXPECT_EQ(configure("", {parameter("task", "full_circle")}).message, "");
  EXPECT_EQ(session.describe().parameters, before.parameters);
  EXPECT_EQ(session.describe().parameters_hash, before.parameters_hash);
  EXPECT_EQ(fromMessage(session.reset(request).state), spawn(100'007));
}

/// A world is told of its draw by a caller that sends no start, or says that its start is one.
TEST_F(SimulatorSessions, TellTheWorldOfADraw) {
  std::vector<std::uint64_t> seeds;
  SimulatorKind drawn = kind();
  drawn.tasks = {"gym_pusht"};
  drawn.loader = [&seeds](const ParameterSet& parameters, const Task& task) {
    SimulatorModel model;
    model.parameters = parameters;
    model.make_world = [&seeds, &task] { return std::make_unique<Drawn>(seeds, task); };
    return model;
  };
  SimulatorSession session(drawn, withTask(drawn), "drawn", [](const auto&) {});
  const auto reset = [&session](std::uint64_t seed, const std::vector<WorldState>& start, bool is_drawn) {
    pusht_msgs::ResetRequest request;
    request.seed = seed;
    request.drawn = is_drawn ? 1 : 0;
    for (const WorldState& state : start) {
      request.start.push_back(toMessage(state));
    }
    return session.reset(request);
  };
  const auto drawn_by = [](std::uint64_t seed) { return spawn(seed, gymPusht()); };
  EXPECT_EQ(fromMessage(reset(7, {}, false).state), drawn_by(7));
  EXPECT_EQ(fromMessage(reset(8, {drawn_by(8)}, true).state), drawn_by(8));
  EXPECT_THAT(seeds, ElementsAre(7U, 8U));
  EXPECT_EQ(fromMessage(reset(9, {drawn_by(8)}, false).state), drawn_by(8)) << "the start counts";
  EXPECT_EQ(fromMessage(reset(0, {drawn_by(0)}, false).state), drawn_by(0));
  EXPECT_EQ(fromMessage(reset(std::uint64_t{1} << 32U, {drawn_by(8)}, false).state), drawn_by(8));
  WorldState of_another_libm = drawn_by(8);
  of_another_libm.tee_position.x() += 1e-16;
  EXPECT_EQ(fromMessage(reset(8, {of_another_libm}, true).state), of_another_libm);
  EXPECT_EQ(reset(9, {drawn_by(8)}, true).message, "reset: the start must be the draw of seed 9");
  EXPECT_THAT(reset(std::uint64_t{1} << 32U, {drawn_by(8)}, true).message, HasSubstr("must be at most 4294967295"));
  EXPECT_THAT(seeds, ElementsAre(7U, 8U, 8U)) << "no other start is a draw";
}

TEST(Conversions, KeepEveryNumberOfAStateInPixels) {
  pusht_msgs::PixelState message;
  double number = 0.1;
  for (double* field : {&message.pusher_x, &message.pusher_y, &message.pusher_vx, &message.pusher_vy, &message.tee_x,
                        &message.tee_y, &message.angle, &message.tee_vx, &message.tee_vy, &message.rate}) {
    *field = number += 1.0;
  }
  EXPECT_EQ(toMessage(fromMessage(message)), message);
}

TEST(Conversions, RefuseAStateInPixelsThatIsNotTheState) {
  const gym_pusht::State state = gym_pusht::drawn(3);
  const WorldState in_table = gym_pusht::toTable(state);
  EXPECT_EQ(inPixels({toMessage(state)}, in_table)->angle, state.angle);
  EXPECT_FALSE(inPixels({}, in_table));
  EXPECT_THROW(inPixels({toMessage(state), toMessage(state)}, in_table), BadDependency);
  for (const double off : {0.1, kNan}) {
    gym_pusht::State other = state;
    other.pusher.x() += off;
    EXPECT_THROW(inPixels({toMessage(other)}, in_table), BadDependency);
    other = state;
    other.tee.y() += off;
    EXPECT_THROW(inPixels({toMessage(other)}, in_table), BadDependency);
    other = state;
    other.angle += off;
    EXPECT_THROW(inPixels({toMessage(other)}, in_table), BadDependency);
  }
}

TEST_F(SimulatorSessions, RefuseATaskThatTheirKindDoesNotHold) {
  EXPECT_EQ(configure("", {parameter("task", "gym_pusht")}).message,
            "task gym_pusht: the kind brittle holds only full_circle");
  EXPECT_THAT(configure("", {parameter("task", "pusht")}).message, HasSubstr("must be one of: full_circle"));
  EXPECT_THAT(session_.describe().parameters, SizeIs(1)) << "nothing has changed";
}

/// A node of a kind of another task is of that one from the start, and says so.
TEST_F(SimulatorSessions, AreOfTheirKindsOwnTask) {
  SimulatorKind gym = kind();
  gym.tasks = {"gym_pusht"};
  SimulatorSession session(gym, withTask(gym), "gym", [](const auto&) {});
  EXPECT_EQ(session.describe().parameters.back(), parameter("task", "gym_pusht"));
}

TEST_F(SimulatorSessions, RefusesWhatTheKindDoesNotTake) {
  for (const auto& [value, reason] : {std::pair("2.5", "steps '2.5': must be a decimal integer"),
                                      std::pair("11", "steps 11: must be from 0 to 10: no test is that patient")}) {
    pusht_msgs::ConfigureRequest request;
    request.parameters = {parameter("steps", value)};
    EXPECT_EQ(session_.configure(request).message, reason);
    EXPECT_EQ(session_.describe().parameters, std::vector{parameter("steps", "2")});
  }
}

TEST_F(SimulatorSessions, RefuseAParameterThatIsSetTwice) {
  const auto refused = configure("", {parameter("steps", "3"), parameter("steps", "4")});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_EQ(refused.message, "parameter steps 3, 4: must be set once");
  EXPECT_EQ(session_.describe().parameters, Parameters{parameter("steps", "2")});
}

TEST_F(SimulatorSessions, DoNotEchoLongTexts) {
  const std::string endless(10'000'000, 'x');
  for (const auto& refused :
       {configure(endless), configure("", {parameter(endless, "1")}), configure("", {parameter("steps", endless)})}) {
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_LT(refused.message.size(), kLongestMessage + 100);
    EXPECT_THAT(refused.message, HasSubstr("bytes left out"));
  }
}

TEST_F(SimulatorSessions, RefuseAYawThatWrapsToNothing) {
  pusht_msgs::ResetRequest request;
  request.start = {toMessage(spawn(3))};
  request.start.front().tee_yaw = 1e300;
  EXPECT_THAT(session_.reset(request).message, HasSubstr("tee_yaw 1e+300 rad: must be within 1000.0 rad"));
  request.start.front().tee_yaw = -1000.0;
  EXPECT_EQ(session_.reset(request).success, 1);
}

TEST_F(SimulatorSessions, AFailedStepNeedsAReset) {
  reset();
  step(0);
  const auto last = step(1);
  const auto failed = step(2);
  EXPECT_EQ(failed.success, 0);
  EXPECT_EQ(failed.exit_code, static_cast<int>(ExitCode::kRuntimeFault));
  EXPECT_THAT(failed.message, HasSubstr("broken on purpose"));
  for (const int index : {-1, 1, 2, 3}) {
    const auto refused = step(index);
    EXPECT_EQ(refused.success, 0);
    EXPECT_EQ(refused.exit_code, static_cast<int>(ExitCode::kInvalidInput));
    EXPECT_THAT(refused.message, HasSubstr("needs a reset"));
  }
  EXPECT_EQ(session_.describe().stamp, last.stamp) << "a step that fails takes no stamp";
  EXPECT_THAT(seen_, SizeIs(3));
  EXPECT_EQ(reset().success, 1);
  EXPECT_EQ(step(0).success, 1);
}

TEST_F(SimulatorSessions, AResetIsNotAnsweredAgainAfterAFailure) {
  pusht_msgs::ConfigureRequest request;
  request.parameters = {parameter("steps", "0")};
  ASSERT_EQ(session_.configure(request).success, 1);
  const auto begun = reset(3, ros::Time(10.0));
  ASSERT_EQ(reset(3, ros::Time(10.0)).success, 1);
  EXPECT_THAT(seen_, SizeIs(1));
  pusht_msgs::StepRequest failing;
  failing.episode = 3;
  ASSERT_EQ(session_.step(failing).success, 0);
  EXPECT_EQ(reset(3, ros::Time(10.0)).success, 0);
  EXPECT_EQ(reset(3, begun.stamp + ros::Duration(0.1)).success, 1);
}

TEST_F(SimulatorSessions, LateStampsDoNotSpoilTheWorld) {
  constexpr std::uint32_t kLimit = 1U << 31U;
  for (const ros::Time late : {ros::Time(kLimit, 0), ros::TIME_MAX}) {
    const auto refused = reset(0, late);
    EXPECT_EQ(refused.exit_code, static_cast<int>(ExitCode::kInvalidInput));
    EXPECT_THAT(refused.message, HasSubstr("must be below 2^31 [s] without a token"));
  }
  EXPECT_EQ(reset(0, ros::Time(kLimit - 1, 999'999'999)).success, 1);
  EXPECT_THAT(step(0, ros::Time(kLimit, 0)).message, HasSubstr("must be below 2^31 [s]"));
  EXPECT_EQ(step(0).stamp, ros::Time(kLimit, 99'999'999)) << "it counts on from there";

  pusht_msgs::ResetRequest run;
  run.token = "mine";
  run.stamp = ros::Time(kLimit, 199'999'999);
  EXPECT_EQ(session_.reset(run).success, 1) << "a caller that names stamps, as a run does, goes on too";
  pusht_msgs::StepRequest next;
  next.token = "mine";
  next.stamp = ros::Time(0U - 1'000'000U, 0);
  EXPECT_THAT(session_.step(next).message, HasSubstr("must be below 2^32 - 10^6 [s]"));
  next.stamp = run.stamp + ros::Duration(0.1);
  EXPECT_EQ(session_.step(next).stamp, next.stamp);
  EXPECT_EQ(reset().success, 1);
}

TEST_F(SimulatorSessions, AFailedStepLeavesTheHold) {
  pusht_msgs::ResetRequest mine;
  mine.token = "mine";
  ASSERT_EQ(session_.reset(mine).success, 1);
  pusht_msgs::StepRequest next;
  next.step = -1;
  next.token = "mine";
  ASSERT_EQ(session_.step(next).success, 1);
  ASSERT_EQ(session_.step(next).success, 1);
  ASSERT_THAT(session_.step(next).message, HasSubstr("broken on purpose"));
  EXPECT_THAT(step(-1).message, HasSubstr("held by another caller"));
  EXPECT_THAT(session_.step(next).message, HasSubstr("needs a reset"));
  pusht_msgs::ConfigureRequest request;
  request.token = "mine";
  EXPECT_EQ(session_.configure(request).success, 1) << "no episode is under way";
}

TEST_F(SimulatorSessions, ARefusedConfigurationKeepsTheSimulator) {
  reset();
  const auto first = step(0);
  pusht_msgs::ConfigureRequest request;
  request.end_episode = 1;
  request.parameters = {parameter("steps", "many")};
  EXPECT_EQ(session_.configure(request).success, 0);
  const auto second = step(1);
  EXPECT_EQ(second.success, 1);
  EXPECT_DOUBLE_EQ(second.state.pusher_x, first.state.pusher_x + 0.1);
}

TEST_F(SimulatorSessions, ARepeatedConfigureIsAnsweredAgain) {
  pusht_msgs::ResetRequest mine;
  mine.token = "mine";
  ASSERT_EQ(session_.reset(mine).success, 1);
  pusht_msgs::ConfigureRequest request;
  request.token = "mine";
  request.end_episode = 1;
  request.parameters = {parameter("steps", "5")};
  const auto first = session_.configure(request);
  ASSERT_EQ(first.success, 1) << first.message;
  EXPECT_EQ(session_.configure(request), first);

  pusht_msgs::ConfigureRequest other = request;
  other.parameters = {parameter("steps", "6")};
  EXPECT_THAT(session_.configure(other).message, HasSubstr("its episode has ended"));
  other = request;
  other.token = "other";
  EXPECT_THAT(session_.configure(other).message, HasSubstr("its episode has ended"));
  EXPECT_EQ(session_.configure(request), first) << "what was refused has changed nothing";
  pusht_msgs::ResetRequest nowhere;
  nowhere.start = {toMessage(spawn(3))};
  nowhere.start.front().tee_x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(session_.reset(nowhere).success, 0);
  EXPECT_EQ(session_.configure(request), first) << "nor a reset that was refused";
  ASSERT_EQ(session_.reset({}).success, 1);
  EXPECT_THAT(session_.configure(request).message, HasSubstr("reset by another caller"));
}

TEST_F(SimulatorSessions, AreOfOneKindUnlessThereAreOthers) {
  EXPECT_THAT(session_.describe().kinds, IsEmpty());
  ASSERT_EQ(configure("", {parameter("steps", "5")}).success, 1);
  EXPECT_EQ(configure("brittle").parameters, std::vector{parameter("steps", "2")}) << "its own, with the defaults";
  for (const char* const other : {"tough", "Brittle", "brittle "}) {
    const std::string reason =
        std::string("simulator '") + other + "': must be brittle, the only kind that this node can be";
    EXPECT_EQ(configure(other).message, reason);
    EXPECT_EQ(describe(other).message, reason);
  }
}

/// Sessions that can become one of another kind, with a parameter of the same name and default and one more.
class KindsOfSessions : public SimulatorSessions {
 protected:
  KindsOfSessions()
      : session_of_kinds_(
            brittle_, brittle_.defaults(), "any", [this](const auto& update) { seen_.push_back(update); }, &kinds_) {
    served_ = &session_of_kinds_;
  }

  static SimulatorKind tough() {
    SimulatorKind tough = kind();
    tough.name = "tough";
    tough.title = "something tough";
    tough.version = "2";
    tough.parameters.push_back({"label", "", "for people", std::string("plain"), 0, 0, "", {"plain", "broken"}});
    tough.parameters.back().presets = {{"plain", {{"steps", "2"}}}};
    tough.start_tolerance = 1e-9;
    tough.loader = [load = tough.loader](const ParameterSet& parameters, const Task& task) {
      if (parameters.get<std::string>("label") == "broken") {
        throw BadDependency("no such engine");
      }
      SimulatorModel model = load(parameters, task);
      model.provenance["tough"] = true;
      return model;
    };
    return tough;
  }

  const SimulatorKind brittle_ = kind();
  const SimulatorKind tough_ = tough();
  const SimulatorKinds kinds_{std::vector{brittle_, tough_}};
  SimulatorSession session_of_kinds_;
};

TEST_F(KindsOfSessions, BecomeAnotherWithItsDefaults) {
  ASSERT_EQ(configure("", {parameter("steps", "5")}).success, 1);
  const auto before = served_->describe();
  EXPECT_THAT(before.kinds, ElementsAre("brittle", "tough"));

  const auto configured = configure("tough");
  ASSERT_EQ(configured.success, 1) << configured.message;
  EXPECT_THAT(configured.parameters, ElementsAre(parameter("steps", "2"), parameter("label", "plain")));
  const auto after = served_->describe();
  EXPECT_EQ(after.name, "tough");
  EXPECT_EQ(after.title, "something tough");
  EXPECT_EQ(after.version, "2");
  EXPECT_EQ(after.kinds, before.kinds);
  EXPECT_EQ(after.parameters, configured.parameters);
  EXPECT_EQ(after.parameters_hash, configured.parameters_hash);
  EXPECT_THAT(after.parameter_descriptors, SizeIs(2));
  EXPECT_EQ(after.start_tolerance, 1e-9);
  EXPECT_EQ(after.provenance, R"({"tough":true})");
  EXPECT_EQ(after.instance_id, before.instance_id);
  EXPECT_EQ(after.frame_prefix, before.frame_prefix);
  EXPECT_THAT(served_->step({}).message, HasSubstr("step before reset"));

  EXPECT_THAT(configure("", {parameter("label", "broken")}).message, HasSubstr("no such engine"));
  ASSERT_EQ(configure("brittle").success, 1);
  EXPECT_EQ(served_->describe().parameters, std::vector{parameter("steps", "2")}) << "what was set is forgotten";
  EXPECT_EQ(configure("", {parameter("label", "plain")}).success, 0) << "of another kind";
}

TEST_F(KindsOfSessions, SetParametersOnTopOfTheDefaults) {
  EXPECT_THAT(configure("tough", {parameter("steps", "7")}).parameters,
              ElementsAre(parameter("steps", "7"), parameter("label", "plain")));
  EXPECT_THAT(configure("tough", {}).parameters, ElementsAre(parameter("steps", "2"), parameter("label", "plain")))
      << "of the kind that it is already";
  EXPECT_THAT(configure("", {parameter("steps", "3")}).parameters,
              ElementsAre(parameter("steps", "3"), parameter("label", "plain")));
}

TEST_F(KindsOfSessions, SimulateWithTheWorldThatTheyHaveBecome) {
  ASSERT_EQ(configure("tough", {parameter("steps", "1")}).success, 1);
  ASSERT_EQ(reset().success, 1);
  EXPECT_EQ(step(0).success, 1);
  EXPECT_THAT(step(1).message, HasSubstr("broken on purpose"));
  EXPECT_THAT(seen_, SizeIs(2));
}

TEST_F(KindsOfSessions, ChangeNothingWhenTheyRefuse) {
  reset();
  step(0);
  const auto before = served_->describe();
  const std::string unknown = "simulator 'rubber': unknown; known: brittle, tough";
  EXPECT_EQ(describe("rubber").message, unknown);
  EXPECT_EQ(describe("rubber").exit_code, static_cast<int>(ExitCode::kInvalidInput));
  EXPECT_EQ(describe("rubber").instance_id, before.instance_id);
  for (const auto& [kind, changes, reason] :
       {std::tuple("rubber", Parameters{}, unknown),
        std::tuple("brittle", Parameters{parameter("label", "plain")},
                   std::string("parameter 'label': unknown; known: steps, task")),
        std::tuple("tough", Parameters{parameter("steps", "11")},
                   std::string("steps 11: must be from 0 to 10: no test is that patient")),
        std::tuple("tough", Parameters{parameter("label", "broken")}, std::string("no such engine"))}) {
    EXPECT_EQ(configure(kind, changes).message, reason);
    EXPECT_EQ(served_->describe(), before);
  }
  EXPECT_EQ(step(1).success, 1) << "the episode goes on";
}

TEST_F(KindsOfSessions, DescribeWhatTheyWouldBe) {
  ASSERT_EQ(configure("", {parameter("steps", "5")}).success, 1);
  const auto begun = reset();
  const auto before = served_->describe();
  const auto planned = describe("tough");
  ASSERT_EQ(planned.success, 1) << planned.message;
  EXPECT_EQ(planned.instance_id, before.instance_id);
  EXPECT_EQ(planned.name, "tough");
  EXPECT_EQ(planned.title, "something tough");
  EXPECT_EQ(planned.version, "2");
  EXPECT_EQ(planned.kinds, before.kinds);
  EXPECT_THAT(planned.parameters, ElementsAre(parameter("steps", "2"), parameter("label", "plain")));
  EXPECT_EQ(planned.parameter_descriptors.at(1).default_value, "plain");
  ASSERT_THAT(planned.parameter_descriptors[1].presets, SizeIs(1));
  EXPECT_EQ(planned.parameter_descriptors[1].presets[0].word, "plain");
  EXPECT_THAT(planned.parameter_descriptors[1].presets[0].settings, ElementsAre(parameter("steps", "2")));
  EXPECT_EQ(planned.start_tolerance, 1e-9);
  EXPECT_EQ(planned.parameters_hash + planned.provenance, "");
  EXPECT_EQ(planned.frame_prefix, "any");
  EXPECT_EQ(planned.stamp, begun.stamp);
  EXPECT_EQ(describe("brittle").parameters, std::vector{parameter("steps", "2")}) << "not as it is";
  EXPECT_EQ(served_->describe(), before);
  EXPECT_EQ(step(0).success, 1);
}

TEST_F(KindsOfSessions, BecomeAnotherForWhoHoldsThem) {
  pusht_msgs::ResetRequest mine;
  mine.token = "mine";
  ASSERT_EQ(served_->reset(mine).success, 1);
  EXPECT_THAT(configure("tough").message, HasSubstr("held by another caller"));
  EXPECT_THAT(configure("rubber").message, HasSubstr("held by another caller")) << "the hold comes first";

  pusht_msgs::ConfigureRequest request;
  request.kind = "tough";
  request.token = "mine";
  EXPECT_THAT(served_->configure(request).message, HasSubstr("mid-episode"));
  EXPECT_EQ(served_->describe().name, "brittle");
  request.end_episode = 1;
  const auto first = served_->configure(request);
  ASSERT_EQ(first.success, 1) << first.message;
  EXPECT_EQ(served_->configure(request), first) << "asked again, it answers again";
  request.kind = "brittle";
  EXPECT_THAT(served_->configure(request).message, HasSubstr("its episode has ended")) << "another request";
  EXPECT_EQ(served_->describe().name, "tough");
}

TEST_F(SimulatorSessions, EveryAnswerNamesTheInstance) {
  const std::string instance = session_.describe().instance_id;
  EXPECT_FALSE(instance.empty());
  EXPECT_EQ(step(0).instance_id, instance) << "refused";
  EXPECT_EQ(reset().instance_id, instance);
  EXPECT_EQ(session_.configure({}).instance_id, instance) << "refused";
  const SimulatorSession other(kind(), kind().defaults(), "brittle", [](const auto&) {});
  EXPECT_NE(other.describe().instance_id, instance);
  EXPECT_EQ(other.describe().parameters_hash, session_.describe().parameters_hash);
}

TEST(SimulatorStarts, WithParametersThatTheKindRefuses) {
  SimulatorKind picky;
  picky.loader = [](const ParameterSet&) -> SimulatorModel { throw InvalidInput("mass -1: must be > 0"); };
  EXPECT_THROW(SimulatorSession(picky, {}, "picky", [](const auto&) {}), InvalidInput);
}

/// Answers with how often the rollout has asked.
class Counting : public Policy {
 public:
  std::unique_ptr<Memory> begin(const Beginning& beginning) const override {
    requireExecutable(beginning, answered);
    return std::make_unique<Count>();
  }
  void act(Span<const Query> queries, Span<Action> actions) override {
    if (fails) {
      throw RuntimeFault("broken on purpose");
    }
    for (std::size_t row = 0; row < queries.size(); ++row) {
      actions[row] = {static_cast<float>(++static_cast<Count*>(queries[row].memory)->asked), 0.0F};
    }
  }

  bool fails = false;
  int answered = 1;

 private:
  struct Count : Memory {
    int asked = 0;
  };
};

/// Fails once, after the first row.
class FailsBetweenRows : public Counting {
 public:
  void act(Span<const Query> queries, Span<Action> actions) override {
    Counting::act({queries.data(), 1}, {actions.data(), 1});
    if (std::exchange(fails_once_, false)) {
      throw RuntimeFault("broken on purpose");
    }
    Counting::act({queries.data() + 1, queries.size() - 1}, {actions.data() + 1, actions.size() - 1});
  }

  void failOnce() { fails_once_ = true; }

 private:
  bool fails_once_ = false;
};

class PolicySessions : public ::testing::Test {
 protected:
  PolicySessions() : session_(model()) {}

  PolicyModel model() {
    auto policy = std::make_unique<Counting>();
    policy_ = policy.get();
    return {"counting", "1", std::move(policy), nlohmann::json::object()};
  }

  using Steps = std::vector<std::pair<std::uint64_t, std::uint32_t>>;

  static pusht_msgs::ActRequest requestOf(const Steps& rollouts) {
    pusht_msgs::ActRequest request;
    for (const auto& [rollout, step] : rollouts) {
      pusht_msgs::Query query;
      query.rollout = rollout;
      query.step = step;
      request.queries.push_back(query);
    }
    return request;
  }

  pusht_msgs::ActResponse act(const Steps& rollouts) { return session_.act(requestOf(rollouts)); }

  Counting* policy_ = nullptr;
  PolicySession session_;
};

TEST_F(PolicySessions, RememberEachRolloutApart) {
  EXPECT_THAT(act({{7, 0}, {9, 0}}).actions, ElementsAre(1, 0, 1, 0));
  EXPECT_THAT(act({{9, 1}}).actions, ElementsAre(2, 0));
  EXPECT_THAT(act({{9, 2}, {7, 1}}).actions, ElementsAre(3, 0, 2, 0));
}

/// Callers do not say when a rollout ends: of many, those are forgotten that were not asked for lately.
TEST_F(PolicySessions, ForgetOfManyRolloutsThoseThatHaveEnded) {
  Steps many;
  for (std::uint64_t rollout = 0; rollout < 1'100; ++rollout) {
    many.emplace_back(rollout, 0);
  }
  act(many);
  for (std::uint32_t step = 1; step <= 1'000; ++step) {
    ASSERT_EQ(act({{7, step}}).success, 1) << "step " << step;
  }
  EXPECT_EQ(act({{7, 1'001}}).success, 1);
  EXPECT_EQ(act({{9, 1}}).success, 0) << "it ended a thousand requests ago";
}

TEST_F(PolicySessions, AnswerTheLastStepAgain) {
  act({{7, 0}});
  act({{7, 1}});
  EXPECT_THAT(act({{7, 1}, {9, 0}}).actions, ElementsAre(2, 0, 1, 0));
  EXPECT_THAT(act({{7, 2}}).actions, ElementsAre(3, 0));
}

TEST_F(PolicySessions, TakeAnotherObservationForAnotherCaller) {
  act({{7, 0}});
  act({{7, 1}});
  pusht_msgs::ActRequest other;
  other.queries.resize(1);
  other.queries[0].rollout = 7;
  other.queries[0].step = 1;
  other.queries[0].observation[2] = 0.5F;
  EXPECT_EQ(session_.act(other).message, "rollout 7: step 1: was answered for another observation");
  EXPECT_THAT(act({{7, 1}}).actions, ElementsAre(2, 0));
}

TEST_F(PolicySessions, BeginARolloutAnewAtStepZero) {
  act({{7, 0}});
  act({{7, 1}});
  EXPECT_THAT(act({{7, 0}}).actions, ElementsAre(1, 0));
  EXPECT_THAT(act({{7, 1}}).actions, ElementsAre(2, 0));
}

TEST_F(PolicySessions, RefuseOtherStepsAndChangeNothing) {
  act({{7, 0}});
  const auto refused = act({{9, 0}, {7, 2}});
  EXPECT_EQ(refused.success, 0);
  EXPECT_EQ(refused.message, "rollout 7: step 2: expected 1");
  EXPECT_EQ(refused.exit_code, static_cast<int>(ExitCode::kInvalidInput));
  EXPECT_EQ(act({{9, 1}}).message, "rollout 9: step 1: expected 0");
  EXPECT_EQ(act({{7, 1}, {7, 1}}).message, "rollout 7: must be asked for once in a request");
  EXPECT_THAT(act({{7, 1}}).actions, ElementsAre(2, 0));
}

TEST_F(PolicySessions, TellThatThePolicyFailed) {
  policy_->fails = true;
  const auto failed = act({{7, 0}});
  EXPECT_EQ(failed.success, 0);
  EXPECT_EQ(failed.exit_code, static_cast<int>(ExitCode::kRuntimeFault));
  EXPECT_EQ(failed.instance_id, session_.describe().instance_id);
  policy_->fails = false;
  EXPECT_THAT(act({{7, 0}}).actions, ElementsAre(1, 0));
}

/// The policy may have stepped some of the memories of a request that failed, and others not.
TEST_F(PolicySessions, ForgetTheRolloutsOfARequestThatFailed) {
  auto policy = std::make_unique<FailsBetweenRows>();
  FailsBetweenRows& failing = *policy;
  PolicySession session({"counting", "1", std::move(policy), nlohmann::json::object()});
  session.act(requestOf({{7, 0}, {8, 0}, {9, 0}}));
  failing.failOnce();
  EXPECT_EQ(session.act(requestOf({{7, 1}, {8, 1}})).message, "broken on purpose");
  EXPECT_EQ(session.act(requestOf({{7, 1}})).message, "rollout 7: step 1: expected 0");
  EXPECT_EQ(session.act(requestOf({{8, 1}})).message, "rollout 8: step 1: expected 0");
  EXPECT_THAT(session.act(requestOf({{9, 1}, {7, 0}})).actions, ElementsAre(2, 0, 1, 0)) << "9 was not asked for";
}

/// A rollout that cannot begin leaves the others of its request as they were.
TEST_F(PolicySessions, RefuseABeginningAndChangeNothing) {
  auto policy = std::make_unique<Counting>();
  policy->answered = 2;
  PolicySession session({"counting", "1", std::move(policy), nlohmann::json::object()});
  session.act(requestOf({{7, 0}}));
  session.act(requestOf({{7, 1}}));
  pusht_msgs::ActRequest request = requestOf({{7, 0}, {9, 0}});
  request.queries[1].execute = 3;
  EXPECT_THAT(session.act(request).message, HasSubstr("execute 3: must be from 1 to 2"));
  EXPECT_THAT(session.act(requestOf({{7, 1}})).actions, ElementsAre(2, 0)) << "its last step, once more";
  EXPECT_THAT(session.act(requestOf({{7, 2}})).actions, ElementsAre(3, 0));
}

TEST_F(PolicySessions, RefuseObservationsThatAreNotFinite) {
  pusht_msgs::ActRequest request;
  request.queries.resize(1);
  request.queries[0].observation[3] = static_cast<float>(kNan);
  EXPECT_EQ(session_.act(request).message, "rollout 0: observation must be finite");
}

}  // namespace
}  // namespace pusht
