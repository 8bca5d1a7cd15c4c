// SPDX-License-Identifier: BSD-3-Clause
/// All that the panel knows of ROS. Without widgets.
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

#include "pusht_rviz/letters.hpp"
#include "pusht_rviz/line.hpp"
#include "pusht_rviz/session.hpp"

namespace pusht_rviz {

/// Talks to an evaluator, or to a replay of the same name, and to the nodes that it works with.
///
/// Methods and signals belong to the thread in which the link lives, that of the GUI, and none of the methods waits for
/// anybody: subscriptions, the action, each node and the master have threads of their own, which leave what they learn
/// in a mailbox; a timer empties it.
class EvaluatorLink : public QObject {
  Q_OBJECT

 public:
  explicit EvaluatorLink(QObject* parent = nullptr);
  ~EvaluatorLink() override;

  /// Begins to talk to an evaluator, and forgets the last one. Not a ROS name: refused().
  void setNamespace(const QString& evaluator);
  QString evaluator() const { return QString::fromStdString(evaluator_); }

  void start(const pusht_msgs::CompareGoal& goal);       ///< goalEnded() says so if it is rejected
  void command(const std::string& word);                 ///< as in Control; it cancels whoever began the run
  void setRate(double rate);                             ///< [control steps/s]; 0: as fast as possible
  void seek(std::uint64_t episode, std::uint32_t step);  ///< the last one counts, if many come fast

  /// Asks a node what a kind would be; described() has the answer.
  void describe(Role role, const QString& kind);

  const pusht_msgs::Progress& progress() const { return progress_; }
  bool served() const { return served_; }                             ///< whether somebody serves the action
  QString policy() const { return QString::fromStdString(policy_); }  ///< namespace of the evaluator's own
  Presence presence(Role role) const { return presence_[role]; }

 Q_SIGNALS:
  void forgotten();  ///< all that came so far was of another evaluator
  void runBegan();   ///< divergence and episodes that came so far are of an earlier run
  void progressed();
  void requestCame(const pusht_msgs::CompareGoal& request);
  void diverged(const pusht_msgs::Divergence& divergence);
  void recalled(const std::vector<pusht_msgs::Divergence>& curve);  ///< of the episode under way, until now
  void episodesFinished(const std::vector<pusht_msgs::EpisodeResult>& episodes);
  void summarised(const pusht_msgs::Summary& summary);
  void goalAccepted();
  void goalEnded(bool rejected, const QString& text);
  void refused(const QString& why);  ///< a command, in words
  void obeyed();                     ///< a command: what was refused before is over
  void presenceChanged(int role);
  void settled();  ///< all that had come was told
  void described(int role, const QString& kind, const pusht_msgs::DescribeResponse& description);
  void policiesFound(const QStringList& namespaces);

 private:
  void attend();
  void open();
  void close();
  void connectNodes(const pusht_msgs::CompareGoal& request);
  std::string serviceOf(const std::vector<std::string>& node) const;
  void connectNode(Role role, const std::vector<std::string>& name);
  void control(const pusht_msgs::ControlRequest& request);
  void askForEpisodes();
  void seekOn();

  void read(const pusht_msgs::Progress& progress);
  void read(const pusht_msgs::Divergence& divergence);
  void read(const pusht_msgs::EpisodeResult& episode);
  void read(const pusht_msgs::Summary& summary);
  void read(const pusht_msgs::CompareGoal& request);
  void read(const GoalNews& news);
  void read(const ActionNews& news);
  void read(const PresenceNews& news);
  void read(const DescriptionNews& news);
  void read(const ControlNews& news);
  void read(const EpisodesNews& news);
  void read(const MasterNews& news);
  void read(const SessionNews& news);

  struct Place {
    std::uint64_t episode;
    std::uint32_t step;
  };

  QTimer timer_;
  std::string evaluator_;
  std::shared_ptr<Post> post_;
  std::unique_ptr<Session> session_;
  std::array<std::unique_ptr<Line>, kRoles> lines_;
  std::array<std::string, kRoles> services_;  // that the lines go to
  std::unique_ptr<Line> episodes_line_;
  std::unique_ptr<Line> master_line_;

  pusht_msgs::Progress progress_;
  bool heard_ = false;  // of the progress of whoever is there now
  bool served_ = false;
  bool open_ = false;
  int unknown_to_master_ = 0;  // how often in a row
  std::string policy_;
  std::vector<std::string> goal_policy_;  // as in the last goal of ours
  std::array<Presence, kRoles> presence_{};
  std::array<std::string, kRoles> known_;  // what was last told of a node's own description
  std::uint64_t episodes_request_ = 0;
  bool seeking_ = false;
  std::optional<Place> next_seek_;
};

}  // namespace pusht_rviz
