// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_rviz/next_run.hpp"

#include <QGridLayout>
#include <QScrollArea>
#include <QSignalBlocker>
#include <QVBoxLayout>
#include <algorithm>
#include <string>

#include "pusht_rviz/quiet_wheel.hpp"
#include "pusht_rviz/theme.hpp"

namespace pusht_rviz {
namespace {

template <class Values>
QString firstOf(const Values& values, const char* otherwise) {
  return values.empty() ? QString(otherwise) : QString::number(values.front());
}

std::string textOf(const QLineEdit* edit) { return edit->text().trimmed().toStdString(); }

void quietly(QLineEdit* edit, const QString& text) {
  const QSignalBlocker quiet(edit);
  edit->setText(text);
}

}  // namespace

NextRun::NextRun(QWidget* parent)
    : QWidget(parent),
      episodes_(makeField("episodes", "how many episodes the run has")),
      run_seed_(makeField("run_seed", "episode i begins from spawn seed 10000 + run seed + i")),
      first_episode_(makeField("first_episode", "index of the first episode")),
      spawn_seed_(makeField("seed", "spawn seed of the first episode: 10000 + run seed + first episode")),
      out_(makeField("out", "folder of the results, from where the evaluator stands; empty: the next free one")),
      policy_(new QComboBox(this)),
      evaluator_(new QLineEdit(this)),
      reference_(new SimulatorForm("reference", this)),
      engine_(new SimulatorForm("engine", this)) {
  auto* const inside = new QWidget;
  auto* const all = new QVBoxLayout(inside);
  all->setContentsMargins(2, 6, 6, 6);
  all->setSpacing(8);

  auto* const grid = new QGridLayout;
  grid->setHorizontalSpacing(6);
  grid->setVerticalSpacing(3);
  grid->setColumnStretch(1, 1);
  grid->setColumnStretch(3, 1);
  int line = 0;
  const auto pair = [&](const char* left, const Field& left_field, const char* right, const Field& right_field) {
    grid->addWidget(new QLabel(left), line, 0);
    grid->addWidget(left_field.edit, line, 1);
    grid->addWidget(new QLabel(right), line, 2);
    grid->addWidget(right_field.edit, line++, 3);
    grid->addWidget(left_field.refusal, line++, 0, 1, 4);
    grid->addWidget(right_field.refusal, line++, 0, 1, 4);
  };
  pair("episodes", episodes_, "run seed", run_seed_);
  pair("from episode", first_episode_, "= seed", spawn_seed_);
  policy_->setObjectName("policy");
  policy_->setToolTip("every policy on this master");
  policy_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  quietWheel(policy_);
  grid->addWidget(new QLabel("policy"), line, 0);
  grid->addWidget(policy_, line++, 1, 1, 3);
  out_.edit->setPlaceholderText("the next free results/compare-N");
  grid->addWidget(new QLabel("results"), line, 0);
  grid->addWidget(out_.edit, line++, 1, 1, 3);
  all->addLayout(grid);
  all->addWidget(reference_);
  all->addWidget(engine_);

  auto* const bottom = new QGridLayout;
  auto* const head = new QLabel("evaluator");
  head->setProperty("dim", true);
  evaluator_->setObjectName("namespace");
  evaluator_->setToolTip("namespace of the evaluator that this panel drives; saved with the configuration");
  bottom->addWidget(head, 0, 0);
  bottom->addWidget(evaluator_, 0, 1);
  all->addLayout(bottom);
  all->addStretch(1);

  auto* const scroll = new QScrollArea(this);
  scroll->setWidget(inside);
  scroll->setWidgetResizable(true);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  auto* const outside = new QVBoxLayout(this);
  outside->setContentsMargins(0, 0, 0, 0);
  outside->addWidget(scroll);

  connect(episodes_.edit, &QLineEdit::textChanged, this, &NextRun::refresh);
  connect(run_seed_.edit, &QLineEdit::textChanged, this, &NextRun::coupleFromEpisode);
  connect(first_episode_.edit, &QLineEdit::textChanged, this, &NextRun::coupleFromEpisode);
  connect(spawn_seed_.edit, &QLineEdit::textChanged, this, &NextRun::coupleFromSeed);
  connect(out_.edit, &QLineEdit::textChanged, this, &NextRun::refresh);
  connect(policy_, QOverload<int>::of(&QComboBox::activated), this, &NextRun::refresh);
  connect(evaluator_, &QLineEdit::editingFinished, this, [this] { Q_EMIT evaluatorChosen(evaluator_->text()); });
  for (SimulatorForm* const form : {reference_, engine_}) {
    const Role role = form == reference_ ? kReference : kEngine;
    connect(form, &SimulatorForm::changed, this, &NextRun::refresh);
    connect(form, &SimulatorForm::kindNeeded, this,
            [this, role](const QString& kind) { Q_EMIT kindNeeded(role, kind); });
  }
  quietly(episodes_.edit, "50");
  quietly(run_seed_.edit, "0");
  quietly(first_episode_.edit, "0");
  coupleFromEpisode();
}

NextRun::Field NextRun::makeField(const char* name, const char* tip) {
  const Field field = {new QLineEdit(this), new QLabel(this)};
  field.edit->setObjectName(name);
  field.edit->setToolTip(tip);
  field.refusal->setObjectName(QString(name) + ".refusal");
  field.refusal->setProperty("refusal", true);
  field.refusal->setWordWrap(true);
  field.refusal->hide();
  return field;
}

void NextRun::setRequest(const pusht_msgs::CompareGoal& request, const QString& policy) {
  known_ = true;
  quietly(episodes_.edit, firstOf(request.episodes, "50"));
  requested_episodes_ =
      request.episodes.empty() ? std::nullopt : std::optional<std::uint32_t>(request.episodes.front());
  quietly(out_.edit, request.out.empty() ? "" : QString::fromStdString(request.out.front()));
  overwrite_ = !request.overwrite.empty() && request.overwrite.front() != 0;
  moveOn();
  quietly(run_seed_.edit, firstOf(request.seed, "0"));
  quietly(first_episode_.edit, firstOf(request.first_episode, "0"));
  spawned_ = request.starts.empty() || request.starts.front().empty();
  spawn_seed_.edit->setEnabled(spawned_);
  spawn_seed_.edit->setPlaceholderText(spawned_ ? "" : "starts are given");
  default_policy_ = policy;
  {
    const QSignalBlocker quiet(policy_);
    policy_->clear();
  }
  showPolicies();
  reference_->setRequest(request.reference.empty() ? "" : request.reference.front(), request.reference_parameters);
  engine_->setRequest(request.engine.empty() ? "" : request.engine.front(), request.engine_parameters);
  coupleFromEpisode();
}

void NextRun::setPolicies(const QStringList& namespaces) {
  if (namespaces != policies_) {
    policies_ = namespaces;
    showPolicies();
  }
}

void NextRun::showPolicies() {
  const QString chosen = policy_->currentIndex() < 0 ? default_policy_ : policy_->currentData().toString();
  QStringList all = policies_;
  for (const QString& name : {default_policy_, chosen}) {
    if (!name.isEmpty() && !all.contains(name)) {
      all << name;
    }
  }
  const QSignalBlocker quiet(policy_);
  policy_->clear();
  for (const QString& name : all) {
    policy_->addItem(policies_.contains(name) ? name : name + "  (not there)", name);
  }
  policy_->setCurrentIndex(policy_->findData(chosen));
}

void NextRun::setDescription(Role role, const QString& kind, const pusht_msgs::DescribeResponse& description) {
  if (role != kReference && role != kEngine) {
    return;
  }
  SimulatorForm* const form = role == kReference ? reference_ : engine_;
  if (kind.isEmpty()) {
    form->setNode(description);
  } else {
    form->setKind(kind, description);
  }
}

void NextRun::setEvaluator(const QString& name) { quietly(evaluator_, name); }

void NextRun::runBegan() {
  began_ = true;
  moveOn();
}

void NextRun::moveOn() {
  if (began_ && !overwrite_) {
    quietly(out_.edit, QString::fromStdString(nextFolder(textOf(out_.edit))));
  }
}

QString NextRun::waitsFor() const {
  if (!known_) {
    return "waiting for the evaluator to say what it would run";
  }
  return reference_->waitsFor().isEmpty() ? engine_->waitsFor() : reference_->waitsFor();
}

void NextRun::forget() {
  known_ = began_ = false;
  reference_->forget();
  engine_->forget();
  policies_.clear();
  default_policy_.clear();
  {
    const QSignalBlocker quiet(policy_);
    policy_->clear();
  }
}

RunDraft NextRun::draft() const {
  RunDraft run;
  run.episodes = textOf(episodes_.edit);
  run.run_seed = textOf(run_seed_.edit);
  run.first_episode = textOf(first_episode_.edit);
  run.spawn_seed = textOf(spawn_seed_.edit);
  run.spawned = spawned_;
  run.out = textOf(out_.edit);
  run.requested_episodes = requested_episodes_;
  run.policy = policy_->currentData().toString().toStdString();
  run.reference = reference_->draft();
  run.engine = engine_->draft();
  return run;
}

void NextRun::coupleFromEpisode() {
  const Reading<std::uint64_t> run_seed = readRunSeed(textOf(run_seed_.edit));
  const Reading<std::uint32_t> episode = readFirstEpisode(textOf(first_episode_.edit));
  if (!spawned_) {
    quietly(spawn_seed_.edit, "");
  } else if (run_seed.refusal.empty() && episode.refusal.empty()) {
    quietly(spawn_seed_.edit, QString::number(kFirstSpawnSeed + run_seed.value + episode.value));
  }
  refresh();
}

void NextRun::coupleFromSeed() {
  const Reading<std::uint64_t> run_seed = readRunSeed(textOf(run_seed_.edit));
  if (run_seed.refusal.empty()) {
    const Reading<std::uint32_t> episode = episodeOfSeed(textOf(spawn_seed_.edit), run_seed.value);
    if (episode.refusal.empty()) {
      quietly(first_episode_.edit, QString::number(episode.value));
    }
  }
  refresh();
}

void NextRun::refresh() {
  const std::vector<Refusal> refusals = goalFrom(draft()).refusals;
  const auto mark = [&](const char* name, const Field& field) {
    const auto refusal = std::find_if(refusals.begin(), refusals.end(),
                                      [&](const Refusal& candidate) { return candidate.field == name; });
    const bool wrong = refusal != refusals.end();
    field.refusal->setText(wrong ? QString::fromStdString(refusal->rule) : "");
    field.refusal->setVisible(wrong);
    theme::mark(field.edit, wrong);
  };
  mark("episodes", episodes_);
  mark("run_seed", run_seed_);
  mark("first_episode", first_episode_);
  mark("spawn_seed", spawn_seed_);
  Q_EMIT changed();
}

}  // namespace pusht_rviz
