// SPDX-License-Identifier: BSD-3-Clause
/// Link between the panel and ROS. Without widgets.
#pragma once

#include <pusht_msgs/ControlRequest.h>

#include <QObject>
#include <QString>
#include <QStringList>
#include <QTimer>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "evaluator_client.hpp"
#include "events.hpp"
#include "service_channel.hpp"

namespace pusht_rviz {

/// Link to an evaluator, or to a replay of the same name, and to the nodes that it works with.
///
/// Methods and signals belong to the thread in which the link lives, that of the GUI, and no method waits.
/// Subscriptions, the action, each node and the master have threads of their own, which push events; a timer handles
/// them.
class EvaluatorLink : public QObject {
  Q_OBJECT

 public:
  explicit EvaluatorLink(QObject* parent = nullptr);
  ~EvaluatorLink() override;

  /// Begins to talk to the evaluator of that namespace. To be called once. Emits refused() if the text is no ROS name.
  void open(const QString& evaluator);
  QString evaluator() const { return QString::fromStdString(evaluator_); }

  void start(const pusht_msgs::CompareGoal& goal);  ///< goalEnded() tells of a rejection
  void command(const std::string& word);            ///< as in Control; `cancel` ends a run that another client began
  void setRate(double rate);                        ///< [control steps/s]; 0: as fast as possible
  void seek(std::uint64_t episode, std::uint32_t step);  ///< of many in a short time the last one counts

  /// Asks a node to describe a kind of simulator; described() has the answer.
  void describe(Node node, const QString& kind);

  const pusht_msgs::Progress& progress() const { return progress_; }
  bool served() const { return served_; }                             ///< whether the action has a server
  QString policy() const { return QString::fromStdString(policy_); }  ///< namespace of the evaluator's default policy
  Presence presence(Node node) const { return presence_[node]; }

 Q_SIGNALS:
  void runBegan();  ///< another run: divergence and episodes that came before are void
  void progressed();
  void requestCame(const pusht_msgs::CompareGoal& request);
  void optionsCame(const pusht_msgs::RunOptions& options);
  void diverged(const pusht_msgs::Divergence& divergence);
  void recalled(const std::vector<pusht_msgs::Divergence>& curve);  ///< of the episode under way, until now
  void episodesFinished(const std::vector<pusht_msgs::EpisodeResult>& episodes);
  void summarized(const pusht_msgs::Summary& summary);
  void goalAccepted();
  void goalEnded(bool rejected, const QString& text);
  void refused(const QString& why);  ///< a command was refused
  void obeyed();                     ///< a command was carried out
  void presenceChanged(int node);
  void settled();  ///< all events that were queued are handled
  void described(int node, const QString& kind, const pusht_msgs::DescribeResponse& description);
  void policiesFound(const QStringList& namespaces);

 private:
  void attend();
  void close();
  void connectNodes(const pusht_msgs::CompareGoal& request);
  std::string serviceOf(const std::vector<std::string>& name) const;
  void connectNode(Node node, const std::vector<std::string>& name);
  void control(const pusht_msgs::ControlRequest& request);
  void seekNext();

  void handle(const pusht_msgs::Progress& progress);
  void handle(const pusht_msgs::Divergence& divergence);
  void handle(const pusht_msgs::EpisodeResult& episode);
  void handle(const pusht_msgs::Summary& summary);
  void handle(const pusht_msgs::CompareGoal& request);
  void handle(const pusht_msgs::RunOptions& options);
  void handle(const GoalEvent& event);
  void handle(const ActionEvent& event);
  void handle(const PresenceEvent& event);
  void handle(const DescriptionEvent& event);
  void handle(const ControlEvent& event);
  void handle(const EpisodesEvent& event);
  void handle(const MasterEvent& event);

  /// Position in a replay.
  struct Position {
    std::uint64_t episode;
    std::uint32_t step;
  };

  QTimer timer_;
  std::string evaluator_;
  std::shared_ptr<Events> events_;
  std::unique_ptr<EvaluatorClient> client_;
  std::array<std::unique_ptr<ServiceChannel>, kNodes> channels_;
  std::array<std::string, kNodes> services_;  // at the other ends of the channels
  std::unique_ptr<ServiceChannel> episodes_channel_;
  std::unique_ptr<ServiceChannel> master_channel_;

  pusht_msgs::Progress progress_;
  bool heard_ = false;   // whether progress_ is of the evaluator that is there now
  bool served_ = false;  // the action
  std::string policy_;
  std::vector<std::string> goal_policy_;  // as in the last goal that was sent
  std::array<Presence, kNodes> presence_{};
  std::array<std::string, kNodes> known_;  // each node's own description, as last told
  std::uint64_t episodes_request_ = 0;     // number of the last request for episodes
  bool seeking_ = false;                   // a seek is not answered yet
  std::optional<Position> next_seek_;
};

}  // namespace pusht_rviz
