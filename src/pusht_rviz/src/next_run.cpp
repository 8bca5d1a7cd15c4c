// SPDX-License-Identifier: BSD-3-Clause
#include "next_run.hpp"

#include <rviz/config.h>

#include <QHBoxLayout>
#include <QVBoxLayout>
#include <vector>

#include "goal.hpp"
#include "theme.hpp"

namespace pusht_rviz {
namespace {

ParameterProperty* rowOf(rviz::Property* parent, const char* name, const char* meaning) {
  pusht_msgs::ParameterDescriptor descriptor;
  descriptor.name = name;
  descriptor.meaning = meaning;
  return new ParameterProperty(descriptor, "", false, parent);
}

/// Sets a value as one that was not edited.
void setBoth(ParameterProperty* row, const std::string& text) {
  row->setBase(text);
  row->setText(text);
}

std::string firstOf(const std::vector<std::string>& values) { return values.empty() ? "" : values.front(); }

/// Rows of parameters that are, or are below, a row.
std::vector<ParameterProperty*> parametersIn(rviz::Property* row) {
  if (auto* const group = qobject_cast<ParameterGroup*>(row)) {
    return group->parameters();
  }
  auto* const parameter = qobject_cast<ParameterProperty*>(row);
  return parameter == nullptr ? std::vector<ParameterProperty*>() : std::vector{parameter};
}

}  // namespace

NextRun::NextRun(QWidget* parent)
    : QWidget(parent),
      model_(new rviz::PropertyTreeModel(new rviz::Property, this)),
      policy_(rowOf(model_->getRoot(), "policy", "policies on this master")),
      out_(rowOf(model_->getRoot(), "results", "folder of the results, from the evaluator's working directory")),
      spawn_seed_(
          rowOf(model_->getRoot(), "spawn_seed", "spawn seed of the first episode: 10000 + seed + first_episode")),
      options_(new ParameterGroup("run", model_->getRoot())),
      reference_(new SimulatorProperty("reference", model_->getRoot())),
      engine_(new SimulatorProperty("engine", model_->getRoot())),
      tree_(new rviz::PropertyTreeWidget(this)),
      reset_(new QToolButton(this)) {
  out_->setPlaceholder("the next free results/compare-N");
  spawn_seed_->setRule([this] { return spawnSeedRefusal(); });
  options_->setReadOnly(true);
  options_->setDescription("options of the run");
  tree_->setObjectName("tree");
  tree_->setModel(model_);
  tree_->setAlternatingRowColors(true);
  tree_->setIndentation(theme::px(14));
  rviz::Config widths;
  widths.mapSetValue("Splitter Ratio", 0.58);  // of the names
  tree_->load(widths);
  tree_->setAnimated(false);  // Qt goes back to the state before it: no row could be edited after a rule was shown
  reset_->setObjectName("reset");
  auto* const all = new QVBoxLayout(this);
  all->setContentsMargins(0, 6, 0, 0);
  all->setSpacing(4);
  all->addWidget(tree_, 1);
  auto* const below = new QHBoxLayout;
  below->addStretch(1);
  below->addWidget(reset_);
  all->addLayout(below);
  connectRows();
  showReset();
}

void NextRun::connectRows() {
  connect(policy_, &rviz::Property::changed, this, &NextRun::refresh);
  connect(out_, &rviz::Property::changed, this, &NextRun::refresh);
  connect(spawn_seed_, &rviz::Property::changed, this, &NextRun::takeSpawnSeed);
  connect(options_, &ParameterGroup::edited, this, &NextRun::showSpawnSeed);
  for (SimulatorProperty* const simulator : {reference_, engine_}) {
    const Node node = simulator == reference_ ? kReference : kEngine;
    connect(simulator, &ParameterGroup::edited, this, &NextRun::refresh);
    connect(simulator, &SimulatorProperty::kindNeeded, this,
            [this, node](const QString& kind) { Q_EMIT kindNeeded(node, kind); });
  }
  connect(tree_, &rviz::PropertyTreeWidget::currentPropertyChanged, this, &NextRun::showReset);
  connect(reset_, &QToolButton::clicked, this, &NextRun::reset);
}

void NextRun::setRequest(const pusht_msgs::CompareGoal& request) {
  requested_ = true;
  overwrite_ = !request.overwrite.empty() && request.overwrite.front() != 0;
  setBoth(out_, firstOf(request.out));
  moveOn();
  spawned_ = firstOf(request.starts).empty();
  spawn_seed_->setReadOnly(!spawned_);
  spawn_seed_->setPlaceholder(spawned_ ? "" : "starts are given");
  setBoth(policy_, firstOf(request.policy_namespace));
  showPolicies();
  reference_->setRequest(firstOf(request.reference), request.reference_parameters);
  engine_->setRequest(firstOf(request.engine), request.engine_parameters);
  showSpawnSeed();
}

void NextRun::setOptions(const pusht_msgs::RunOptions& options) {
  options_->build(options);
  spawn_seed_->setBase(spawn_seed_->text());
}

void NextRun::setPolicies(const QStringList& namespaces) {
  if (namespaces != policies_) {
    policies_ = namespaces;
    showPolicies();
  }
}

void NextRun::showPolicies() {
  const QString chosen = QString::fromStdString(policy_->text());
  QStringList all = policies_;
  for (const QString& name : {QString::fromStdString(policy_->base()), chosen}) {
    if (!name.isEmpty() && !all.contains(name)) {
      all << name;
    }
  }
  policy_->setWords(all);
  policy_->setSuffix(chosen.isEmpty() || policies_.contains(chosen) ? "" : " (not there)");
}

void NextRun::setDescription(Node node, const QString& kind, const pusht_msgs::DescribeResponse& description) {
  SimulatorProperty* const simulator = node == kReference ? reference_ : engine_;
  if (kind.isEmpty()) {
    simulator->setNode(description);
  } else {
    simulator->setKind(kind, description);
  }
}

void NextRun::runBegan() {
  began_ = true;
  moveOn();
}

void NextRun::moveOn() {
  if (began_ && !overwrite_) {
    setBoth(out_, nextFolder(out_->text()));
  }
}

QString NextRun::waitsFor() const {
  if (!requested_ || options_->numChildren() == 0) {
    return "waiting for the evaluator to describe its runs";
  }
  return reference_->waitsFor().isEmpty() ? engine_->waitsFor() : reference_->waitsFor();
}

pusht_msgs::CompareGoal NextRun::goal(std::optional<double> rate) const {
  pusht_msgs::CompareGoal goal;
  goal.options = options_->named();
  goal.out = {out_->text()};
  if (!policy_->text().empty()) {
    goal.policy_namespace = {policy_->text()};
  }
  if (rate) {
    goal.rate = {*rate};
  }
  if (!reference_->kind().empty()) {
    goal.reference = {reference_->kind()};
  }
  if (!engine_->kind().empty()) {
    goal.engine = {engine_->kind()};
  }
  goal.reference_parameters = reference_->named();
  goal.engine_parameters = engine_->named();
  return goal;
}

std::string NextRun::refusal() const {
  for (const std::string& rule :
       {options_->refusal(), spawn_seed_->refusal(), reference_->refusal(), engine_->refusal()}) {
    if (!rule.empty()) {
      return rule;
    }
  }
  return "";
}

/// Text of an option; empty if there is none of that name.
std::string NextRun::option(const char* name) const {
  const ParameterProperty* const row = options_->find(name);
  return row == nullptr ? "" : row->text();
}

std::string NextRun::spawnSeedRefusal() const {
  const bool looked_at = spawned_ && options_->find(kSeedOption) != nullptr;
  return looked_at ? firstEpisodeOf(spawn_seed_->text(), option(kSeedOption)).refusal : "";
}

/// Makes the spawn seed follow the options.
void NextRun::showSpawnSeed() {
  if (refreshing_) {
    return;
  }
  refreshing_ = true;
  const std::optional<std::uint64_t> seed = spawnSeedOf(option(kSeedOption), option(kFirstEpisodeOption));
  if (!spawned_) {
    setBoth(spawn_seed_, "");
  } else if (seed) {
    spawn_seed_->setText(std::to_string(*seed));
  }
  refreshing_ = false;
  refresh();
}

/// Makes the first episode follow the spawn seed.
void NextRun::takeSpawnSeed() {
  if (refreshing_) {
    return;
  }
  refreshing_ = true;
  const Reading episode = firstEpisodeOf(spawn_seed_->text(), option(kSeedOption));
  if (ParameterProperty* const first = options_->find(kFirstEpisodeOption);
      first != nullptr && episode.refusal.empty()) {
    first->setText(std::to_string(episode.value));
  }
  refreshing_ = false;
  refresh();
}

/// Shows the rules that are broken below their rows.
void NextRun::refresh() {
  if (refreshing_) {
    return;
  }
  for (int i = 0; i < model_->getRoot()->numChildren(); ++i) {
    for (ParameterProperty* const row : parametersIn(model_->getRoot()->childAt(i))) {
      row->showRule();
      if (row->numChildren() > 0) {
        tree_->setFirstColumnSpanned(0, model_->indexOf(row), true);
      }
    }
  }
  showPolicies();
  showReset();
  Q_EMIT changed();
}

void NextRun::showReset() {
  const std::vector<ParameterProperty*> rows = parametersIn(model_->getProp(tree_->currentIndex()));
  const bool one = rows.size() == 1;
  bool any = false;
  for (const ParameterProperty* const row : rows) {
    any = any || row->differs();
  }
  reset_->setEnabled(any);
  reset_->setText(QString::fromUtf8("↺ ") +
                  (any && one ? "back to " + QString::fromStdString(rows.front()->base()) : QString("take back")));
  reset_->setToolTip("takes the value of the current row back, or all values below it");
}

void NextRun::reset() {
  for (ParameterProperty* const row : parametersIn(model_->getProp(tree_->currentIndex()))) {
    row->setText(row->base());
  }
}

}  // namespace pusht_rviz
