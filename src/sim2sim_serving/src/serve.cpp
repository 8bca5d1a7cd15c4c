// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/serve.hpp"

#include <ros/ros.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "pusht_task/error.hpp"
#include "sim2sim_serving/conversions.hpp"
#include "sim2sim_serving/health.hpp"
#include "sim2sim_serving/node.hpp"
#include "sim2sim_serving/transforms.hpp"
#include "sim2sim_serving/world_markers.hpp"

namespace pusht {
namespace {

/// Counts of answered and refused requests.
struct Tally {
  std::uint64_t answered = 0;
  std::uint64_t refused = 0;
  std::string last_refusal;

  template <class Response>
  const Response& count(const Response& response) {
    ++(response.success != 0 ? answered : refused);
    if (response.success == 0) {
      last_refusal = response.message;
      ROS_WARN_STREAM("refused: " << response.message);
    }
    return response;
  }

  void report(DiagnosticStatusWrapper& status) const {
    status.summary(diagnostic_msgs::DiagnosticStatus::OK, "serving");
    status.add("answered", answered);
    status.add("refused", refused);
    status.add("last refusal", last_refusal);
  }
};

class SimulatorNode {
 public:
  SimulatorNode(const ros::NodeHandle& node, const SimulatorKind& kind, const SimulatorKinds* kinds,
                const ParameterSet& parameters, const std::string& frame_prefix)
      : frame_prefix_(frame_prefix),
        node_(node),
        state_(node_.advertise<pusht_msgs::WorldStateStamped>("state", kQueue)),
        markers_(node_.advertise<visualization_msgs::MarkerArray>("markers", 1, true)),
        health_(kind.name, "requests", [this](DiagnosticStatusWrapper& status) { tally_.report(status); }),
        session_(
            kind, parameters, frame_prefix, [this](const pusht_msgs::WorldStateStamped& update) { publish(update); },
            kinds),
        services_{node_.advertiseService("reset", &SimulatorNode::reset, this),
                  node_.advertiseService("step", &SimulatorNode::step, this),
                  node_.advertiseService("configure", &SimulatorNode::configure, this),
                  node_.advertiseService("describe", &SimulatorNode::describe, this)},
        caption_(captionOf(session_.describe())) {
    show();
    repeating_ =
        node_.createSteadyTimer(ros::WallDuration(kRepeatPeriod), [this](const ros::SteadyTimerEvent&) { repeat(); });
  }

 private:
  static constexpr std::uint32_t kQueue = 1000;
  static constexpr double kRepeatPeriod = 1.0;       // [s]
  static constexpr double kShowPeriod = 1.0 / 30.0;  // [s] at least: a run at full speed does not pay for its picture

  bool reset(pusht_msgs::ResetRequest& request, pusht_msgs::ResetResponse& response) {
    response = tally_.count(session_.reset(request));
    return true;
  }
  bool step(pusht_msgs::StepRequest& request, pusht_msgs::StepResponse& response) {
    response = tally_.count(session_.step(request));
    return true;
  }
  bool configure(pusht_msgs::ConfigureRequest& request, pusht_msgs::ConfigureResponse& response) {
    const pusht_msgs::DescribeResponse before = session_.describe();
    response = tally_.count(session_.configure(request));
    if (response.success != 0) {
      follow(request.kind, before, response.parameters);
      caption_ = captionOf(session_.describe());
      show();
    }
    return true;
  }
  bool describe(pusht_msgs::DescribeRequest& request, pusht_msgs::DescribeResponse& response) {
    response = session_.describe(request);
    return true;
  }

  /// Makes the node's parameters tell what it is. Wherever it dies meanwhile, it can be started with them.
  void follow(const std::string& kind, const pusht_msgs::DescribeResponse& before, const Parameters& now) {
    for (const pusht_msgs::Parameter& old : before.parameters) {
      if (std::none_of(now.begin(), now.end(), [&](const auto& parameter) { return parameter.name == old.name; })) {
        node_.deleteParam(old.name);
      }
    }
    if (!kind.empty() && !before.kinds.empty()) {
      setParameters(node_, {parameter("kind", kind)});
      health_.setHardware(kind);
    }
    setParameters(node_, now);
  }

  void publish(const pusht_msgs::WorldStateStamped& update) {
    const WorldState state = fromMessage(update.state);
    moving_ = movingFrames(frame_prefix_, state, update.header.stamp);
    frames_.sendTransform(moving_);
    state_.publish(update);
    caption_.moment = {update.episode, update.step, state};
    if (ros::SteadyTime::now() - shown_ >= ros::WallDuration(kShowPeriod) && markers_.getNumSubscribers() > 0) {
      show();
    }  // else repeat() does
  }

  /// Geometry and caption together: only the last message is latched.
  void show() {
    if (shown_task_ != &caption_.task.get()) {
      shown_task_ = &caption_.task.get();
      fixed_frames_.sendTransform(targetFrame(frame_prefix_, shown_task_->target));
    }
    visualization_msgs::MarkerArray picture = worldMarkers(frame_prefix_, *shown_task_);
    const visualization_msgs::MarkerArray caption = captionMarkers(frame_prefix_, caption_);
    picture.markers.insert(picture.markers.end(), caption.markers.begin(), caption.markers.end());
    markers_.publish(picture);
    shown_ = ros::SteadyTime::now();
  }

  /// Sends the last step again for late subscribers and after rviz's Reset. tf2 warns of a repeated stamp, so stamps
  /// grow.
  void repeat() {
    for (geometry_msgs::TransformStamped& frame : moving_) {
      frame.header.stamp += ros::Duration(0, 1);
    }
    frames_.sendTransform(moving_);
    show();
  }

  std::string frame_prefix_;
  ros::NodeHandle node_;
  tf2_ros::TransformBroadcaster frames_;
  tf2_ros::StaticTransformBroadcaster fixed_frames_;
  std::vector<geometry_msgs::TransformStamped> moving_;  // as sent last; empty before the first reset
  ros::Publisher state_;
  ros::Publisher markers_;
  Tally tally_;
  Health health_;
  SimulatorSession session_;
  std::array<ros::ServiceServer, 4> services_;
  Caption caption_;
  const Task* shown_task_ = nullptr;
  ros::SteadyTime shown_;
  ros::SteadyTimer repeating_;
};

class PolicyNode {
 public:
  PolicyNode(const ros::NodeHandle& node, PolicyModel model)
      : node_(node),
        health_(model.name, "requests", [this](DiagnosticStatusWrapper& status) { tally_.report(status); }),
        session_(std::move(model)),
        services_{node_.advertiseService("act", &PolicyNode::act, this),
                  node_.advertiseService("describe", &PolicyNode::describe, this)} {}

 private:
  bool act(pusht_msgs::ActRequest& request, pusht_msgs::ActResponse& response) {
    response = tally_.count(session_.act(request));
    return true;
  }
  bool describe(pusht_msgs::DescribeRequest& /*request*/, pusht_msgs::DescribeResponse& response) {
    response = session_.describe();
    return true;
  }

  ros::NodeHandle node_;
  Tally tally_;
  Health health_;
  PolicySession session_;
  std::array<ros::ServiceServer, 2> services_;
};

/// Serves nothing but the error of a node that failed at start, until the node ends.
void serveFailure(ros::NodeHandle& node, const std::exception& failure) {
  const pusht_msgs::DescribeResponse answer = describeFailure(failure);
  const Health health("none", "requests", [&](DiagnosticStatusWrapper& status) {
    status.summary(diagnostic_msgs::DiagnosticStatus::ERROR, answer.message);
  });
  using Callback = boost::function<bool(pusht_msgs::DescribeRequest&, pusht_msgs::DescribeResponse&)>;
  const Callback describe = [&](pusht_msgs::DescribeRequest&, pusht_msgs::DescribeResponse& response) {
    response = answer;
    return true;
  };
  const ros::ServiceServer service = node.advertiseService("describe", describe);
  ros::spin();
}

/// Runs `make` for what serves requests as long as it lives.
int serve(int argc, char** argv, const std::string& node_name,
          const std::function<std::shared_ptr<void>(const ros::NodeHandle&, ParameterReader&)>& make) {
  return runNode(argc, argv, node_name, NoMaster::kWait, [&] {
    requireClock();
    ros::NodeHandle node("~");
    std::shared_ptr<void> served;
    try {
      ParameterReader parameters(node);
      parameters.enterWorkingDirectory();
      served = make(node, parameters);
    } catch (const std::exception& failure) {
      reportFailure(node_name, failure);
      serveFailure(node, failure);
      return exitCodeOf(failure);
    }
    ros::spin();
    return ExitCode::kOk;
  });
}

std::shared_ptr<SimulatorNode> makeNode(const ros::NodeHandle& node, const SimulatorKind& kind,
                                        const SimulatorKinds* kinds, ParameterReader& parameters) {
  const std::string frame_prefix = parameters.text("frame_prefix", ros::this_node::getName().substr(1));
  const ParameterSet values = parameters.changed(withTask(kind));
  parameters.refuseUnknown();
  return std::make_shared<SimulatorNode>(node, kind, kinds, values, frame_prefix);
}

}  // namespace

int serveSimulator(int argc, char** argv, const std::string& node_name, const SimulatorKind& kind) {
  return serve(argc, argv, node_name, [&](const ros::NodeHandle& node, ParameterReader& parameters) {
    return makeNode(node, kind, nullptr, parameters);
  });
}

int serveAnySimulator(int argc, char** argv, const std::string& node_name) {
  return serve(argc, argv, node_name, [](const ros::NodeHandle& node, ParameterReader& parameters) {
    const SimulatorKinds& kinds = SimulatorKinds::installed();
    return makeNode(node, kinds.named(parameters.text("kind", "")), &kinds, parameters);
  });
}

int servePolicy(int argc, char** argv, const std::string& node_name,
                const std::function<PolicyModel(ParameterReader&)>& load) {
  return serve(argc, argv, node_name, [&](const ros::NodeHandle& node, ParameterReader& parameters) {
    PolicyModel model = load(parameters);
    parameters.refuseUnknown();
    return std::make_shared<PolicyNode>(node, std::move(model));
  });
}

}  // namespace pusht
