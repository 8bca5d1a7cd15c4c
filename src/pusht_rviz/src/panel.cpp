// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_rviz/panel.hpp"

#include <ros/names.h>
#include <rviz/config.h>
#include <rviz/visualization_manager.h>

#include <QAction>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QScrollArea>
#include <QSignalBlocker>
#include <QStringList>
#include <QTimer>
#include <QVBoxLayout>
#include <algorithm>
#include <pluginlib/class_list_macros.hpp>
#include <string>

#include "pusht_rviz/buttons.hpp"
#include "pusht_rviz/numbers.hpp"
#include "pusht_rviz/theme.hpp"

namespace pusht_rviz {
namespace {

constexpr const char* kNamespaceKey = "Namespace";
constexpr const char* kDefaultNamespace = "/sim2sim";
constexpr const char* kWidthKey = "Width";
constexpr std::array kRates = {2.0, 10.0, 25.0, 50.0, 100.0, 0.0};  // [control steps/s]; the last: full speed
constexpr double kRealTime = 1.0 / kControlStep;

QString paceLabel(double rate) {
  const QString text = QString::fromStdString(paceText(rate));
  return rate == kRealTime ? text + ", real time" : text;
}

/// How a node is shown: never by colour alone.
struct Look {
  const char* symbol;
  const char* word;
  QColor colour;
};

Look lookOf(Presence presence, bool busy) {
  switch (presence) {
    case Presence::kAlive:
      return busy ? Look{"▶", "busy", theme::kReference} : Look{"●", "alive", theme::kGood};
    case Presence::kSilent:
      return {"…", "gives no answer", theme::kEngine};
    case Presence::kLost:
      return {"✕", "lost", theme::kBad};
    case Presence::kWaiting:
      break;
  }
  return {"○", "not there yet", theme::kAxis};
}

QPushButton* largeButton(QWidget* parent, const char* name, const QString& text, theme::Shape shape, const char* tip) {
  auto* const button = new QPushButton(theme::icon(shape), text, parent);
  button->setObjectName(name);
  button->setToolTip(tip);
  button->setProperty("large", true);
  button->setMinimumWidth(10);
  button->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  return button;
}

}  // namespace

Panel::Panel(QWidget* parent)
    : rviz::Panel(parent),
      start_(largeButton(this, "start", "Start", theme::Shape::kStart, "begins the run that `Next run` describes")),
      pause_(largeButton(this, "pause", "Pause", theme::Shape::kPause, "")),
      step_(largeButton(this, "step", "Step", theme::Shape::kStep, "one control step of 0.1 s, while paused")),
      cancel_(largeButton(this, "cancel", "Cancel", theme::Shape::kStop, "ends the run; finished episodes are kept")),
      rate_(new QComboBox(this)),
      progress_(new QProgressBar(this)),
      status_(new QLabel(this)),
      views_(new ViewButtons(this)),
      replay_controls_(new ReplayControls(this)),
      tabs_(new QTabWidget(this)),
      episodes_(new EpisodesModel(this)),
      strip_(new EpisodeStrip(episodes_, this)),
      summary_(new SummaryView(strip_, this)),
      curves_(new Curves(this)),
      next_run_(new NextRun(this)),
      episode_list_(new QTableView(this)),
      go_to_episode_(new QPushButton(this)),
      play_icon_(theme::icon(theme::Shape::kPlay)),
      pause_icon_(theme::icon(theme::Shape::kPause)) {
  setAttribute(Qt::WA_StyledBackground);
  setStyleSheet(theme::styleSheet());
  auto* const all = new QVBoxLayout(this);
  all->setContentsMargins(6, 6, 6, 4);
  all->setSpacing(6);
  buildControls();
  buildTabs();
  connectLink();
  setReplay(false);
  showState();
}

QSize Panel::sizeHint() const { return {width_, 640}; }

void Panel::buildControls() {
  auto* const all = static_cast<QVBoxLayout*>(layout());
  auto* const row = new QHBoxLayout;
  row->setSpacing(4);
  for (QPushButton* const button : {start_, pause_, step_, cancel_}) {
    row->addWidget(button, 1);
  }
  all->addLayout(row);

  rate_->setObjectName("rate");
  rate_->setToolTip("control steps per second; a control step is 0.1 s");
  progress_->setObjectName("progress");
  progress_->setMinimumWidth(100);
  auto* const pace = new QHBoxLayout;
  pace->setSpacing(4);
  pace->addWidget(rate_);
  pace->addWidget(progress_, 1);
  all->addLayout(pace);

  auto* const line = new QHBoxLayout;
  line->setSpacing(4);
  for (std::size_t role = 0; role < kRoles; ++role) {
    nodes_.at(role) = new QLabel(this);
    nodes_.at(role)->setObjectName(QString("node.") + kRoleNames.at(role));
    nodes_.at(role)->setStyleSheet("font-size: " + QString::number(theme::px(12)) + "px");
    line->addWidget(nodes_.at(role));
    if (role + 1 < kRoles) {
      line->addStretch(1);
    }
  }
  all->addLayout(line);

  status_->setObjectName("status");
  status_->setWordWrap(true);
  status_->setTextFormat(Qt::PlainText);
  status_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  all->addWidget(status_);
  all->addWidget(replay_controls_);
  all->addWidget(views_);
  views_->setObjectName("views");

  connect(start_, &QPushButton::clicked, this, &Panel::start);
  connect(pause_, &QPushButton::clicked, this, &Panel::pauseOrResume);
  connect(step_, &QPushButton::clicked, this, [this] {
    said_.clear();
    link_.command(pusht_msgs::ControlRequest::STEP);
  });
  connect(cancel_, &QPushButton::clicked, this, [this] {
    said_.clear();
    cancelling_ = true;
    link_.command(pusht_msgs::ControlRequest::CANCEL);
    showState();
  });
  connect(rate_, QOverload<int>::of(&QComboBox::activated), this, &Panel::chooseRate);
  connect(replay_controls_, &ReplayControls::stepChosen, this, [this](std::uint32_t step) {
    shown_step_ = step;
    link_.seek(shown_episode_, shown_step_);
  });
  connect(replay_controls_, &ReplayControls::seedChosen, this, &Panel::goToSeed);
}

void Panel::buildTabs() {
  auto* const run = new QWidget;
  auto* const column = new QVBoxLayout(run);
  column->setContentsMargins(0, 2, 0, 0);
  column->setSpacing(2);
  column->addWidget(summary_);
  column->addWidget(curves_, 1);
  auto* const scroll = new QScrollArea;  // a long failure leaves little room: figures must not be cut
  scroll->setWidget(run);
  scroll->setWidgetResizable(true);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);

  auto* const list = new QWidget;
  auto* const list_column = new QVBoxLayout(list);
  list_column->setContentsMargins(0, 6, 0, 0);
  list_column->setSpacing(4);
  list_column->addWidget(episode_list_, 1);
  list_column->addWidget(go_to_episode_);
  go_to_episode_->setObjectName("go_to_episode");
  episode_list_->setObjectName("episode_list");
  episode_list_->setModel(episodes_);
  episode_list_->setSelectionBehavior(QAbstractItemView::SelectRows);
  episode_list_->setSelectionMode(QAbstractItemView::SingleSelection);
  episode_list_->setAlternatingRowColors(true);
  episode_list_->setShowGrid(false);
  episode_list_->setWordWrap(false);
  episode_list_->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);  // what is cut is in the tool tip
  // Fixed heights and widths: nothing has to look at ten thousand rows.
  episode_list_->verticalHeader()->hide();
  episode_list_->verticalHeader()->setSectionResizeMode(QHeaderView::Fixed);
  episode_list_->verticalHeader()->setDefaultSectionSize(theme::px(22));
  episode_list_->horizontalHeader()->setMinimumSectionSize(24);
  episode_list_->horizontalHeader()->setSectionResizeMode(EpisodesModel::kCause, QHeaderView::Stretch);
  constexpr std::array kWidths = {34, 50, 72, 64, 44};
  for (std::size_t i = 0; i < kWidths.size(); ++i) {
    episode_list_->setColumnWidth(static_cast<int>(i), theme::px(kWidths.at(i)));
  }
  connect(episode_list_, &QTableView::doubleClicked, this, [this](const QModelIndex& index) { goToRow(index.row()); });
  connect(go_to_episode_, &QPushButton::clicked, this, [this] { goToRow(episode_list_->currentIndex().row()); });
  connect(strip_, &EpisodeStrip::clicked, this, &Panel::goTo);

  tabs_->setObjectName("tabs");
  tabs_->tabBar()->setObjectName("tab_bar");
  tabs_->setUsesScrollButtons(false);
  tabs_->addTab(scroll, "This run");
  tabs_->addTab(next_run_, "Next run");
  tabs_->addTab(list, "Episodes");
  static_cast<QVBoxLayout*>(layout())->addWidget(tabs_, 1);

  connect(tabs_, &QTabWidget::currentChanged, this, &Panel::showStatus);
  connect(next_run_, &NextRun::changed, this, &Panel::showState);
  connect(next_run_, &NextRun::kindNeeded, this,
          [this](int role, const QString& kind) { link_.describe(static_cast<Role>(role), kind); });
  connect(next_run_, &NextRun::evaluatorChosen, this, [this](const QString& name) {
    said_.clear();
    link_.setNamespace(name);
    next_run_->setEvaluator(link_.evaluator());
    showState();
    Q_EMIT configChanged();
  });
}

void Panel::connectLink() {
  connect(&link_, &EvaluatorLink::forgotten, this, [this] {
    summary_->clear();
    next_run_->forget();
    asked_ = cancelling_ = false;
    last_run_ = 0;
    live_episode_.reset();
    request_rate_.reset();
    faults_ = {};
    titles_ = {};
  });
  connect(&link_, &EvaluatorLink::forgotten, episodes_, &EpisodesModel::clear);
  connect(&link_, &EvaluatorLink::forgotten, curves_, &Curves::clear);
  connect(&link_, &EvaluatorLink::runBegan, this, [this] {
    episodes_->clear();
    curves_->clear();
    asked_ = cancelling_ = false;
    live_episode_.reset();
    const std::uint32_t run = link_.progress().run;
    if (run != 0 && run != last_run_) {  // a goal that failed before its run began has left its folder free
      next_run_->runBegan();
    }
    last_run_ = run;
  });
  connect(&link_, &EvaluatorLink::progressed, this, &Panel::showState);
  connect(&link_, &EvaluatorLink::requestCame, this, [this](const pusht_msgs::CompareGoal& request) {
    if (!request.bound_position.empty() && !request.bound_angle.empty()) {
      curves_->setBound(request.bound_position.front(), request.bound_angle.front());
    }
    request_rate_ = request.rate.empty() ? std::nullopt : std::optional(request.rate.front());
    next_run_->setRequest(request, link_.policy());
    showState();
  });
  connect(&link_, &EvaluatorLink::diverged, this, [this](const pusht_msgs::Divergence& divergence) {
    curves_->add(divergence);
    shown_episode_ = divergence.episode;
    shown_step_ = divergence.step;
    live_episode_ = divergence.episode;
  });
  connect(&link_, &EvaluatorLink::settled, this, [this] {
    showStrip();
    if (replay_) {
      showScrubber();
    }
  });
  connect(&link_, &EvaluatorLink::episodesFinished, episodes_, &EpisodesModel::add);
  connect(&link_, &EvaluatorLink::summarised, summary_, &SummaryView::show);
  connect(&link_, &EvaluatorLink::summarised, this,
          [this](const pusht_msgs::Summary& summary) { curves_->setFloor(floorOf(summary)); });
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
  connect(&link_, &EvaluatorLink::recalled, curves_, &Curves::recall);
  connect(&link_, &EvaluatorLink::presenceChanged, this, &Panel::showState);
  connect(&link_, &EvaluatorLink::policiesFound, next_run_, &NextRun::setPolicies);
  connect(&link_, &EvaluatorLink::described, this,
          [this](int role, const QString& kind, const pusht_msgs::DescribeResponse& description) {
            if (kind.isEmpty()) {
              const std::string& title = description.title.empty() ? description.name : description.title;
              titles_.at(static_cast<std::size_t>(role)) = QString::fromStdString(title);
              faults_.at(static_cast<std::size_t>(role)) = description.success != 0 ? "" : description.message;
            }
            next_run_->setDescription(static_cast<Role>(role), kind, description);
            showState();
          });
}

void Panel::onInitialize() {
  views_->setViews(vis_manager_->getViewManager());
  // A configuration, if there is one, names another evaluator before this comes to pass.
  auto* const soon = new QTimer(this);
  soon->setSingleShot(true);
  connect(soon, &QTimer::timeout, this, [this] {
    if (link_.evaluator().isEmpty()) {
      link_.setNamespace(kDefaultNamespace);
      next_run_->setEvaluator(link_.evaluator());
    }
  });
  soon->start(0);
}

void Panel::load(const rviz::Config& config) {
  rviz::Panel::load(config);
  QString name;
  if (config.mapGetString(kNamespaceKey, &name) && !name.isEmpty()) {
    link_.setNamespace(name);
    next_run_->setEvaluator(link_.evaluator());
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
  RunDraft run = next_run_->draft();
  run.rate = chosen_rate_;
  const Draft draft = goalFrom(run);
  if (!draft.refusals.empty()) {
    return;  // which is why the button could not be pressed
  }
  said_.clear();
  asked_ = true;
  link_.start(draft.goal);
  showState();
}

void Panel::pauseOrResume() {
  said_.clear();
  if (link_.progress().paused != 0) {
    link_.command(pusht_msgs::ControlRequest::RESUME);
  } else {
    link_.command(pusht_msgs::ControlRequest::PAUSE);
  }
  showState();
}

void Panel::chooseRate() {
  chosen_rate_ = rate_->currentData().toDouble();
  said_.clear();
  link_.setRate(*chosen_rate_);
}

void Panel::goTo(std::uint64_t episode) {
  said_.clear();
  replay_controls_->refuse("");
  const std::optional<int> row = episodes_->rowOfEpisode(episode);
  if (row) {
    episode_list_->selectRow(*row);
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

void Panel::goToRow(int row) {
  if (row >= 0 && row < episodes_->rowCount()) {
    goTo(episodes_->row(row).episode);
  }
}

void Panel::goToSeed() {
  const std::string text = replay_controls_->seed().toStdString();
  const std::optional<std::uint64_t> seed = decimal<std::uint64_t>(text);
  const std::optional<int> row = seed ? episodes_->rowOfSeed(*seed) : std::nullopt;
  if (row) {
    goToRow(*row);
    return;
  }
  const QString seeds = episodes_->seedsText();
  replay_controls_->refuse("seed " + (text.empty() ? "''" : QString::fromStdString(text)) +
                           ": must be one of this run's, " + (seeds.isEmpty() ? "which has none" : seeds));
}

void Panel::showState() {
  const pusht_msgs::Progress& progress = link_.progress();
  const Draft draft = goalFrom(next_run_->draft());
  Situation situation;
  situation.reachable = link_.presence(kEvaluator) == Presence::kAlive;
  situation.compares = link_.served();
  situation.asked = asked_;
  situation.busy = progress.busy != 0;
  situation.paused = progress.paused != 0;
  situation.replay = progress.replay != 0;
  situation.cancelling = cancelling_;
  situation.waits_for = next_run_->waitsFor().toStdString();
  situation.refusal = draft.refusals.empty() ? "" : "next run: " + draft.refusals.front().rule;
  refusal_ = QString::fromStdString(situation.refusal);
  if (!situation.busy) {
    cancelling_ = false;
  }
  const Buttons buttons = buttonsFor(situation);
  setReplay(situation.replay);
  start_->setEnabled(buttons.start);
  start_->setToolTip(buttons.start ? "begins the run that `Next run` describes"
                                   : QString::fromStdString(buttons.why_not));
  pause_->setEnabled(buttons.pause);
  pause_->setText(buttons.resumes ? (replay_ ? "Play" : "Resume") : "Pause");
  pause_->setIcon(buttons.resumes ? play_icon_ : pause_icon_);
  pause_->setToolTip(buttons.resumes ? "goes on" : "takes no further control step");
  step_->setEnabled(buttons.step);
  cancel_->setEnabled(buttons.cancel);
  rate_->setEnabled(buttons.rate);
  showRate();
  showProgress();
  for (std::size_t role = 0; role < kRoles; ++role) {
    showNode(role);
  }
  showStatus();
}

void Panel::showRate() {
  const pusht_msgs::Progress& progress = link_.progress();
  const bool runs = progress.busy != 0 || progress.replay != 0;
  const double rate = runs ? progress.rate : chosen_rate_.value_or(request_rate_.value_or(progress.rate));
  const QSignalBlocker quiet(rate_);
  if (rate_->count() == 0) {
    for (const double each : kRates) {
      rate_->addItem(paceLabel(each), each);
    }
  }
  if (rate_->findData(rate) < 0) {
    rate_->insertItem(0, paceLabel(rate), rate);
  }
  if (rate_->currentIndex() != rate_->findData(rate) && !rate_->view()->isVisible()) {
    rate_->setCurrentIndex(rate_->findData(rate));
  }
}

void Panel::showProgress() {
  const pusht_msgs::Progress& progress = link_.progress();
  const int episodes = static_cast<int>(progress.episodes);
  const int finished = static_cast<int>(progress.episodes_finished);
  progress_->setRange(0, std::max(1, episodes));
  progress_->setValue(finished);
  QStringList words;
  if (episodes > 0) {
    words << QString::number(finished) + " / " + QString::number(episodes);
  }
  if (cancelling_) {
    words << "ending";
  } else if (progress.paused != 0) {
    words << "paused";
  } else if (!progress.waiting_for.empty()) {
    words << "waits for " + QString::fromStdString(progress.waiting_for);
  } else if (progress.busy != 0 && progress.replay == 0) {
    const QString left = QString::fromStdString(timeLeftText(progress.seconds_left));
    words << (left.isEmpty() ? "runs" : left);
  } else if (asked_) {
    words << "begins";
  }
  progress_->setFormat(words.isEmpty() ? "no run yet" : words.join(QString::fromUtf8(" · ")));
}

void Panel::showNode(std::size_t role) {
  const Presence presence = link_.presence(static_cast<Role>(role));
  Look look = lookOf(presence, link_.progress().busy != 0);
  const std::string& fault = faults_.at(role);
  const bool failed = presence == Presence::kAlive && !fault.empty();
  if (failed) {
    look = {"!", "failed at its start", theme::kBad};
  }
  const QString name = role == kEvaluator && replay_ ? "player" : kRoleNames.at(role);
  QLabel* const label = nodes_.at(role);
  label->setText("<span style='color:" + look.colour.name() + "'>" + QString::fromUtf8(look.symbol) + "</span>&nbsp;" +
                 name);
  label->setToolTip(name + ": " + look.word + (failed ? ": " + QString::fromStdString(fault) : "") +
                    (titles_.at(role).isEmpty() ? "" : " (" + titles_.at(role) + ")"));
  label->setVisible(!replay_ || role == kEvaluator);
}

void Panel::showStatus() {
  QStringList lines;
  if (!said_.isEmpty()) {
    lines << said_;
  }
  for (std::size_t role = 0; role < kRoles; ++role) {
    const Presence presence = link_.presence(static_cast<Role>(role));
    if (presence == Presence::kLost || presence == Presence::kSilent) {
      lines << QString(kRoleNames.at(role)) + ": " + lookOf(presence, false).word;
    } else if (!faults_.at(role).empty()) {
      lines << QString(kRoleNames.at(role)) + ": " + QString::fromStdString(faults_.at(role));
    }
  }
  const pusht_msgs::Progress& progress = link_.progress();
  // Beside the field, too; but perhaps that is not in sight.
  if (!refusal_.isEmpty() && progress.busy == 0 && tabs_->currentWidget() != next_run_) {
    lines << refusal_;
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

void Panel::showScrubber() {
  const std::optional<int> row = episodes_->rowOfEpisode(shown_episode_);
  replay_controls_->show(shown_episode_, shown_step_, row ? &episodes_->row(*row) : nullptr);
}

void Panel::showStrip() {
  // The first episode to finish is the first of the run, unless it is under way.
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
      tabs_->insertTab(next_run, next_run_, "Next run");
    }
  }
  replay_ = replay;
  curves_->setReplay(replay);
  start_->setVisible(!replay);
  cancel_->setVisible(!replay);
  replay_controls_->setVisible(replay);
  go_to_episode_->setText(replay ? "Go to this episode" : "Show the curves of this episode");
}

}  // namespace pusht_rviz

PLUGINLIB_EXPORT_CLASS(pusht_rviz::Panel, rviz::Panel)
