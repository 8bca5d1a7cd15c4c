// SPDX-License-Identifier: BSD-3-Clause
#include "panel.hpp"

#include <rviz/config.h>
#include <rviz/visualization_manager.h>

#include <QScrollArea>
#include <QStringList>
#include <QTabBar>
#include <QTimer>
#include <QVBoxLayout>
#include <algorithm>
#include <pluginlib/class_list_macros.hpp>
#include <string>

#include "drawing_end.hpp"
#include "texts.hpp"
#include "theme.hpp"

namespace pusht_rviz {
namespace {

constexpr const char* kNamespaceKey = "Namespace";
constexpr const char* kDefaultNamespace = "/sim2sim";
constexpr const char* kWidthKey = "Width";
constexpr const char* kNextRunTab = "Next run";

QScrollArea* scrolled(QWidget* inside) {
  auto* const scroll = new QScrollArea;
  scroll->setWidget(inside);
  scroll->setWidgetResizable(true);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  return scroll;
}

}  // namespace

Panel::Panel(QWidget* parent)
    : rviz::Panel(parent),
      run_controls_(new RunControls(this)),
      node_row_(new NodeRow(this)),
      status_(new QLabel(this)),
      replay_controls_(new ReplayControls(this)),
      views_(new ViewButtons(this)),
      tabs_(new QTabWidget(this)),
      episodes_(new EpisodesModel(this)),
      strip_(new EpisodeStrip(episodes_, this)),
      summary_(new SummaryView(strip_, this)),
      curves_(new Curves(this)),
      next_run_(new NextRun(this)),
      episode_list_(new EpisodeList(episodes_, this)) {
  setAttribute(Qt::WA_StyledBackground);
  setStyleSheet(theme::styleSheet());
  buildLayout();
  connectControls();
  connectLink();
  connectCurves();
  connectGoals();
  setReplay(false);
  showState();
}

QSize Panel::sizeHint() const { return {width_, 640}; }

void Panel::buildLayout() {
  status_->setObjectName("status");
  status_->setWordWrap(true);
  status_->setTextFormat(Qt::PlainText);
  status_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  views_->setObjectName("views");

  auto* const run = new QWidget;
  auto* const column = new QVBoxLayout(run);
  column->setContentsMargins(0, 2, 0, 0);
  column->setSpacing(2);
  column->addWidget(summary_);
  column->addWidget(curves_, 1);

  tabs_->setObjectName("tabs");
  tabs_->tabBar()->setObjectName("tab_bar");
  tabs_->setUsesScrollButtons(false);
  tabs_->addTab(scrolled(run), "This run");  // below a long failure there is little height, and figures must not be cut
  tabs_->addTab(next_run_, kNextRunTab);
  tabs_->addTab(episode_list_, "Episodes");

  auto* const all = new QVBoxLayout(this);
  all->setContentsMargins(6, 6, 6, 4);
  all->setSpacing(6);
  for (QWidget* const widget :
       std::initializer_list<QWidget*>{run_controls_, node_row_, status_, replay_controls_, views_}) {
    all->addWidget(widget);
  }
  all->addWidget(tabs_, 1);
}

void Panel::connectControls() {
  connect(run_controls_, &RunControls::startPressed, this, &Panel::start);
  connect(run_controls_, &RunControls::pausePressed, this, [this] {
    const bool paused = link_.progress().paused != 0;
    command(paused ? pusht_msgs::ControlRequest::RESUME : pusht_msgs::ControlRequest::PAUSE);
  });
  connect(run_controls_, &RunControls::stepPressed, this, [this] { command(pusht_msgs::ControlRequest::STEP); });
  connect(run_controls_, &RunControls::cancelPressed, this, [this] {
    cancelling_ = true;
    command(pusht_msgs::ControlRequest::CANCEL);
  });
  connect(run_controls_, &RunControls::rateChosen, this, [this](double rate) {
    chosen_rate_ = rate;
    said_.clear();
    link_.setRate(rate);
  });
  connect(replay_controls_, &ReplayControls::stepChosen, this, [this](std::uint32_t step) {
    shown_step_ = step;
    link_.seek(shown_episode_, shown_step_);
  });
  connect(episode_list_, &EpisodeList::chosen, this, &Panel::goTo);
  connect(strip_, &EpisodeStrip::clicked, this, &Panel::goTo);
  connect(tabs_, &QTabWidget::currentChanged, this, &Panel::showStatus);
  connect(next_run_, &NextRun::changed, this, &Panel::showState);
  connect(next_run_, &NextRun::kindNeeded, this,
          [this](int node, const QString& kind) { link_.describe(static_cast<Node>(node), kind); });
}

void Panel::connectLink() {
  connect(&link_, &EvaluatorLink::runBegan, this, &Panel::beginRun);
  connect(&link_, &EvaluatorLink::progressed, this, &Panel::showState);
  connect(&link_, &EvaluatorLink::requestCame, this, [this](const pusht_msgs::CompareGoal& request) {
    if (!request.bound_position.empty() && !request.bound_angle.empty()) {
      curves_->setBound(request.bound_position.front(), request.bound_angle.front());
    }
    request_rate_ = request.rate.empty() ? std::nullopt : std::optional(request.rate.front());
    next_run_->setRequest(request);
    showState();
  });
  connect(&link_, &EvaluatorLink::optionsCame, next_run_, &NextRun::setOptions);
  connect(&link_, &EvaluatorLink::nodesChanged, this, [this] {
    node_row_->setStatuses(link_.statuses());
    next_run_->setPolicies(link_.policies());
    showState();
  });
  connect(&link_, &EvaluatorLink::described, this,
          [this](int node, const QString& kind, const pusht_msgs::DescribeResponse& description) {
            next_run_->setDescription(static_cast<Node>(node), kind, description);
            showState();
          });
}

void Panel::connectCurves() {
  connect(&link_, &EvaluatorLink::diverged, this, [this](const pusht_msgs::Divergence& divergence) {
    curves_->add(divergence);
    shown_episode_ = divergence.episode;
    shown_step_ = divergence.step;
    live_episode_ = divergence.episode;
  });
  connect(&link_, &EvaluatorLink::recalled, curves_, &Curves::recall);
  connect(&link_, &EvaluatorLink::episodesFinished, episodes_, &EpisodesModel::add);
  connect(&link_, &EvaluatorLink::summarized, this, [this](const pusht_msgs::Summary& summary) {
    summary_->show(summary);
    curves_->setFloor(floorOf(summary));
  });
  connect(&link_, &EvaluatorLink::settled, this, [this] {
    showStrip();
    showReplay();
  });
}

void Panel::connectGoals() {
  connect(&link_, &EvaluatorLink::goalAccepted, this, [this] {
    tabs_->setCurrentIndex(0);
    asked_ = false;
    showState();
  });
  connect(&link_, &EvaluatorLink::goalEnded, this, [this](bool rejected, const QString& text) {
    asked_ = false;
    if (rejected) {
      said_ = text;
    }
    showState();
  });
  connect(&link_, &EvaluatorLink::refused, this, [this](const QString& why) {
    said_ = why;
    cancelling_ = false;
    showState();
  });
  connect(&link_, &EvaluatorLink::obeyed, this, [this] {
    said_.clear();
    showStatus();
  });
}

void Panel::beginRun() {
  episodes_->clear();
  curves_->clear();
  asked_ = cancelling_ = false;
  live_episode_.reset();
  const std::uint32_t run = link_.progress().run;
  if (run != 0 && run != last_run_) {  // a goal that failed before its run began has left its folder free
    next_run_->runBegan();
  }
  last_run_ = run;
}

void Panel::onInitialize() {
  new DrawingEnd(vis_manager_, this);
  views_->setViews(vis_manager_->getViewManager());
  // The timer fires after load(), which may name another evaluator.
  auto* const soon = new QTimer(this);
  soon->setSingleShot(true);
  connect(soon, &QTimer::timeout, this, [this] {
    if (link_.evaluator().isEmpty()) {
      link_.open(kDefaultNamespace);
    }
  });
  soon->start(0);
}

void Panel::load(const rviz::Config& config) {
  rviz::Panel::load(config);
  QString name;
  if (config.mapGetString(kNamespaceKey, &name) && !name.isEmpty()) {
    link_.open(name);
  }
  config.mapGetInt(kWidthKey, &width_);
  updateGeometry();
}

void Panel::save(rviz::Config config) const {
  rviz::Panel::save(config);
  config.mapSetValue(kNamespaceKey, link_.evaluator());
  config.mapSetValue(kWidthKey, width_);
}

void Panel::start() {
  if (!next_run_->refusal().empty()) {
    return;  // the button is disabled then
  }
  said_.clear();
  asked_ = true;
  link_.start(next_run_->goal(chosen_rate_));
  showState();
}

void Panel::command(const std::string& word) {
  said_.clear();
  link_.command(word);
  showState();
}

void Panel::goTo(std::uint64_t episode) {
  said_.clear();
  const std::optional<int> row = episodes_->rowOfEpisode(episode);
  if (row) {
    episode_list_->select(*row);
  }
  if (replay_) {
    link_.seek(episode, 0);
  } else if (!curves_->choose(episode)) {
    said_ = "episode " + QString::number(episode) + ": " +
            (row ? "the panel keeps the curves of the last " + QString::number(CurveStore::kKept) + " episodes it saw"
                 : "it has not begun");
  }
  showStatus();
  showStrip();
}

Situation Panel::situation() const {
  const pusht_msgs::Progress& progress = link_.progress();
  const std::string refusal = next_run_->refusal();
  Situation situation;
  situation.reachable = link_.statuses()[kEvaluator].presence == pusht_msgs::NodeStatus::ALIVE;
  situation.compares = link_.served();
  situation.asked = asked_;
  situation.busy = progress.busy != 0;
  situation.paused = progress.paused != 0;
  situation.replay = progress.replay != 0;
  situation.cancelling = cancelling_;
  situation.waits_for = next_run_->waitsFor().toStdString();
  situation.refusal = refusal.empty() ? "" : "next run: " + refusal;
  return situation;
}

void Panel::showState() {
  const pusht_msgs::Progress& progress = link_.progress();
  cancelling_ = cancelling_ && progress.busy != 0;
  const Situation now = situation();
  setReplay(now.replay);
  run_controls_->show(now, progress);
  run_controls_->showRate(now.busy || now.replay ? progress.rate
                                                 : chosen_rate_.value_or(request_rate_.value_or(progress.rate)));
  node_row_->show(now.busy, now.replay);
  showStatus();
}

void Panel::showStatus() {
  QStringList lines;
  if (!said_.isEmpty()) {
    lines << said_;
  }
  lines << node_row_->complaints();
  const pusht_msgs::Progress& progress = link_.progress();
  // The form shows the rule beside its field, but only while its tab is open.
  const std::string refusal = situation().refusal;
  if (!refusal.empty() && progress.busy == 0 && tabs_->currentWidget() != next_run_) {
    lines << QString::fromStdString(refusal);
  }
  if (!progress.waiting_for.empty()) {
    lines << "the run waits for the node " + QString::fromStdString(progress.waiting_for);
  }
  if (progress.busy == 0 && !progress.failure.empty()) {
    lines << "the last run ended early: " + QString::fromStdString(progress.failure);
  }
  status_->setText(lines.join('\n'));
  status_->setVisible(!lines.isEmpty());
}

void Panel::showReplay() {
  if (replay_) {
    const std::optional<int> row = episodes_->rowOfEpisode(shown_episode_);
    replay_controls_->show(shown_episode_, shown_step_, row ? &episodes_->row(*row) : nullptr);
  }
}

void Panel::showStrip() {
  // The first episode to finish is the first of the run, unless that is under way.
  std::optional<std::uint64_t> first = live_episode_;
  if (episodes_->rowCount() > 0) {
    first = std::min(episodes_->row(0).episode, first.value_or(episodes_->row(0).episode));
  }
  strip_->setRun(first ? link_.progress().episodes : 0, first.value_or(0));
  strip_->setShown(curves_->chosen());
}

void Panel::setReplay(bool replay) {
  if (replay != replay_) {
    const int next_run = 1;
    if (replay) {
      tabs_->removeTab(next_run);
      next_run_->hide();
    } else {
      tabs_->insertTab(next_run, next_run_, kNextRunTab);
    }
  }
  replay_ = replay;
  curves_->setReplay(replay);
  replay_controls_->setVisible(replay);
  episode_list_->setReplay(replay);
}

}  // namespace pusht_rviz

PLUGINLIB_EXPORT_CLASS(pusht_rviz::Panel, rviz::Panel)
