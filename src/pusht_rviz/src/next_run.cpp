// SPDX-License-Identifier: BSD-3-Clause
#include "next_run.hpp"

#include <QGridLayout>
#include <QGroupBox>
#include <QScrollArea>
#include <QSignalBlocker>
#include <QVBoxLayout>
#include <algorithm>
#include <string>

#include "quiet_wheel.hpp"
#include "theme.hpp"

namespace pusht_rviz {
namespace {

std::string textOf(const QLineEdit* edit) { return edit->text().trimmed().toStdString(); }

/// Sets a text without a signal.
void quietly(QLineEdit* edit, const QString& text) {
  const QSignalBlocker quiet(edit);
  edit->setText(text);
}

QLineEdit* makeField(QWidget* parent, const char* name, const char* tip) {
  auto* const field = new QLineEdit(parent);
  field->setObjectName(name);
  field->setToolTip(tip);
  return field;
}

/// Text of an option in the form; empty if there is none of that name.
std::string optionIn(const ParameterDraft& options, const char* name) {
  const std::optional<std::size_t> index = options.find(name);
  return index ? options[*index].text : "";
}

std::string firstOf(const std::vector<std::string>& values) { return values.empty() ? "" : values.front(); }

}  // namespace

NextRun::NextRun(QWidget* parent)
    : QWidget(parent),
      options_(new ParameterForm("", this)),
      spawn_seed_(makeField(this, "spawn_seed", "spawn seed of the first episode: 10000 + seed + first_episode")),
      spawn_seed_refusal_(new QLabel(this)),
      out_(makeField(this, "out", "folder of the results, from the evaluator's working directory")),
      policy_(new QComboBox(this)),
      reference_(new SimulatorForm("reference", this)),
      engine_(new SimulatorForm("engine", this)) {
  auto* const inside = new QWidget;
  auto* const all = new QVBoxLayout(inside);
  all->setContentsMargins(2, 6, 6, 6);
  all->setSpacing(8);
  all->addWidget(runGroup());
  all->addWidget(reference_);
  all->addWidget(engine_);
  all->addStretch(1);

  auto* const scroll = new QScrollArea(this);
  scroll->setWidget(inside);
  scroll->setWidgetResizable(true);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  auto* const outside = new QVBoxLayout(this);
  outside->setContentsMargins(0, 0, 0, 0);
  outside->addWidget(scroll);
  connectControls();
}

QWidget* NextRun::runGroup() {
  spawn_seed_refusal_->setObjectName("spawn_seed.refusal");
  spawn_seed_refusal_->setProperty("refusal", true);
  spawn_seed_refusal_->setWordWrap(true);
  spawn_seed_refusal_->hide();
  out_->setPlaceholderText("the next free results/compare-N");
  policy_->setObjectName("policy");
  policy_->setToolTip("policies on this master");
  policy_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  quietWheel(policy_);

  auto* const group = new QGroupBox("run");
  auto* const column = new QVBoxLayout(group);
  column->setContentsMargins(8, 6, 8, 6);
  column->setSpacing(6);
  column->addWidget(options_);
  auto* const grid = new QGridLayout;
  grid->setHorizontalSpacing(6);
  grid->setVerticalSpacing(3);
  grid->setColumnStretch(1, 1);
  grid->addWidget(new QLabel("spawn seed"), 0, 0);
  grid->addWidget(spawn_seed_, 0, 1);
  grid->addWidget(spawn_seed_refusal_, 1, 0, 1, 2);
  grid->addWidget(new QLabel("policy"), 2, 0);
  grid->addWidget(policy_, 2, 1);
  grid->addWidget(new QLabel("results"), 3, 0);
  grid->addWidget(out_, 3, 1);
  column->addLayout(grid);
  return group;
}

void NextRun::connectControls() {
  connect(options_, &ParameterForm::changed, this, &NextRun::showSpawnSeed);
  connect(spawn_seed_, &QLineEdit::textChanged, this, &NextRun::takeSpawnSeed);
  connect(out_, &QLineEdit::textChanged, this, &NextRun::refresh);
  connect(policy_, QOverload<int>::of(&QComboBox::activated), this, &NextRun::refresh);
  for (SimulatorForm* const form : {reference_, engine_}) {
    const Node node = form == reference_ ? kReference : kEngine;
    connect(form, &SimulatorForm::changed, this, &NextRun::refresh);
    connect(form, &SimulatorForm::kindNeeded, this,
            [this, node](const QString& kind) { Q_EMIT kindNeeded(node, kind); });
  }
}

void NextRun::setRequest(const pusht_msgs::CompareGoal& request) {
  requested_ = true;
  quietly(out_, QString::fromStdString(firstOf(request.out)));
  overwrite_ = !request.overwrite.empty() && request.overwrite.front() != 0;
  moveOn();
  spawned_ = firstOf(request.starts).empty();
  spawn_seed_->setEnabled(spawned_);
  spawn_seed_->setPlaceholderText(spawned_ ? "" : "starts are given");
  default_policy_ = QString::fromStdString(firstOf(request.policy_namespace));
  {
    const QSignalBlocker quiet(policy_);
    policy_->clear();
  }
  showPolicies();
  reference_->setRequest(firstOf(request.reference), request.reference_parameters);
  engine_->setRequest(firstOf(request.engine), request.engine_parameters);
  showSpawnSeed();
}

void NextRun::setOptions(const pusht_msgs::RunOptions& options) { options_->build(ParameterDraft(options)); }

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

void NextRun::setDescription(Node node, const QString& kind, const pusht_msgs::DescribeResponse& description) {
  if (node != kReference && node != kEngine) {
    return;
  }
  SimulatorForm* const form = node == kReference ? reference_ : engine_;
  if (kind.isEmpty()) {
    form->setNode(description);
  } else {
    form->setKind(kind, description);
  }
}

void NextRun::runBegan() {
  began_ = true;
  moveOn();
}

void NextRun::moveOn() {
  if (began_ && !overwrite_) {
    quietly(out_, QString::fromStdString(nextFolder(textOf(out_))));
  }
}

QString NextRun::waitsFor() const {
  if (!requested_ || options_->draft().size() == 0) {
    return "waiting for the evaluator to describe its runs";
  }
  return reference_->waitsFor().isEmpty() ? engine_->waitsFor() : reference_->waitsFor();
}

RunDraft NextRun::draft() const {
  RunDraft run;
  run.options = options_->draft();
  run.spawn_seed = textOf(spawn_seed_);
  run.spawned = spawned_;
  run.out = textOf(out_);
  run.policy = policy_->currentData().toString().toStdString();
  run.reference = reference_->draft();
  run.engine = engine_->draft();
  return run;
}

/// Makes the spawn seed follow the options.
void NextRun::showSpawnSeed() {
  const ParameterDraft& options = options_->draft();
  const std::optional<std::uint64_t> seed =
      spawnSeedOf(optionIn(options, kSeedOption), optionIn(options, kFirstEpisodeOption));
  if (!spawned_) {
    quietly(spawn_seed_, "");
  } else if (seed) {
    quietly(spawn_seed_, QString::number(*seed));
  }
  refresh();
}

/// Makes the first episode follow the spawn seed.
void NextRun::takeSpawnSeed() {
  const Reading episode = firstEpisodeOf(textOf(spawn_seed_), optionIn(options_->draft(), kSeedOption));
  if (episode.refusal.empty()) {
    options_->setText(kFirstEpisodeOption, QString::number(episode.value));
  }
  refresh();
}

void NextRun::refresh() {
  const std::vector<Refusal> refusals = goalFrom(draft()).refusals;
  const auto refusal =
      std::find_if(refusals.begin(), refusals.end(), [](const Refusal& one) { return one.field == "spawn_seed"; });
  const bool wrong = refusal != refusals.end();
  spawn_seed_refusal_->setText(wrong ? QString::fromStdString(refusal->rule) : "");
  spawn_seed_refusal_->setVisible(wrong);
  theme::mark(spawn_seed_, wrong);
  Q_EMIT changed();
}

}  // namespace pusht_rviz
