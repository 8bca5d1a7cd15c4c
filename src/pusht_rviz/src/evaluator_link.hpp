// SPDX-License-Identifier: BSD-3-Clause
/// Link between the panel and ROS. Without widgets.
#pragma once

#include <pusht_msgs/CompareGoal.h>
#include <pusht_msgs/Control.h>
#include <pusht_msgs/DescribeResponse.h>
#include <pusht_msgs/Divergence.h>
#include <pusht_msgs/Episodes.h>
#include <pusht_msgs/Nodes.h>
#include <pusht_msgs/Progress.h>
#include <pusht_msgs/RunOptions.h>
#include <pusht_msgs/Summary.h>

#include <QObject>
#include <QString>
#include <QStringList>
#include <QTimer>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nodes.hpp"
#include "worker.hpp"

namespace pusht_rviz {

/// Presence of an evaluator, as in NodeStatus. `silence`: time since its last message of `nodes`; none: there was none.
/// `gone`: it has closed the connection to `control`, or takes none.
std::uint8_t evaluatorPresence(std::optional<std::chrono::nanoseconds> silence, bool gone);

/// Link to an evaluator, or to a replay of the same name.
///
/// A worker subscribes to the evaluator's topics and calls services. Messages, what becomes of goals, and answers wait
/// in one callback queue, which a timer empties 25 times a second; so all handlers and signals are in the thread in
/// which the link lives, that of the GUI. No method waits.
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

  /// Asks the node of the reference or the engine to describe a kind of simulator; described() has the answer.
  void describe(Node node, const QString& kind);

  const pusht_msgs::Progress& progress() const { return progress_; }
  bool served() const { return served_; }                     ///< whether the action has a server
  const NodeStatuses& statuses() const { return statuses_; }  ///< of the evaluator: presence alone
  const QStringList& policies() const { return policies_; }   ///< namespaces of those on the master

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
  void nodesChanged();               ///< statuses() or policies()
  void settled();                    ///< all that was queued is handled
  void described(int node, const QString& kind, const pusht_msgs::DescribeResponse& description);

 private:
  struct Ros;
  static void look(Ros& ros, EvaluatorLink* link);
  static void subscribe(Ros& ros, EvaluatorLink* link);

  void attend();
  void showPresence();
  void control(const pusht_msgs::ControlRequest& request);
  void seekNext();
  void askForEpisodes();

  void onProgress(const pusht_msgs::Progress& progress);
  void onEpisode(const pusht_msgs::EpisodeResult& episode);
  void onRequest(const pusht_msgs::CompareGoal& request);
  void onNodes(const pusht_msgs::Nodes& nodes);
  void onControl(const std::string& command, bool done, const std::string& message);
  void onDescription(Node node, const std::string& kind, const pusht_msgs::DescribeResponse* description);

  /// Position in a replay.
  struct Position {
    std::uint64_t episode;
    std::uint32_t step;
  };

  QTimer timer_;
  std::string evaluator_;
  std::shared_ptr<Ros> ros_;
  std::unique_ptr<Worker> worker_;

  pusht_msgs::Progress progress_;
  bool heard_ = false;   // whether progress_ is of the evaluator that is there now
  bool served_ = false;  // the action
  NodeStatuses statuses_{};
  QStringList policies_;
  std::optional<std::chrono::steady_clock::time_point> nodes_at_;  // time of the last message of `nodes`
  std::array<std::string, 2> services_;                            // of reference and engine, in the next run
  std::array<std::string, 2> known_;    // identity of the node that has described itself, or is asked to
  std::uint64_t episodes_request_ = 0;  // number of the last request for episodes; an answer to another is void
  bool seeking_ = false;                // a seek is not answered yet
  std::optional<Position> next_seek_;
};

}  // namespace pusht_rviz
