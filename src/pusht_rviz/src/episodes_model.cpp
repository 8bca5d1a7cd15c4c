// SPDX-License-Identifier: BSD-3-Clause
#include "episodes_model.hpp"

#include <QBrush>
#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

#include "pusht_task/constants.hpp"
#include "texts.hpp"
#include "theme.hpp"

namespace pusht_rviz {
namespace {

QString inWords(const std::string& name) { return QString::fromStdString(name).replace('_', ' '); }

QString seconds(std::uint32_t steps) { return QString::number(pusht::kControlStep * steps, 'f', 1) + " s"; }

QString outcome(const EpisodeRow::Closed& closed) {
  return closed.success ? QString::fromUtf8("✓ solved") : QString::fromUtf8("✗ ") + inWords(closed.ending);
}

/// "✗ stuck after 30.0 s: its tee lies still from 4.1 s on; its pusher then: moving"
QString outcomeText(const EpisodeRow::Closed& closed) {
  const QString after = outcome(closed) + " after " + seconds(closed.steps);
  return closed.ending != "stuck" ? after
                                  : after + ": its tee lies still from " + seconds(closed.still_step) +
                                        " on; its pusher then: " + inWords(closed.pusher_ending);
}

QString text(const EpisodeRow& row, int column) {
  switch (column) {
    case EpisodesModel::kEpisode:
      return QString::number(row.episode);
    case EpisodesModel::kSeed:
      return row.seed == 0 ? QString::fromUtf8(kDash) : QString::number(row.seed);
    case EpisodesModel::kReference:
      return outcome(row.reference);
    case EpisodesModel::kEngine:
      return outcome(row.engine);
    case EpisodesModel::kFirstDivergence:
      return row.parting_step == 0 ? QString::fromUtf8(kDash) : seconds(row.parting_step);
    case EpisodesModel::kCause:
      return row.parting_step == 0 ? "stays together" : row.parting_cause;
    default:
      return "";
  }
}

QString toolTip(const EpisodeRow& row, int column) {
  switch (column) {
    case EpisodesModel::kReference:
      return "reference: " + outcomeText(row.reference);
    case EpisodesModel::kEngine:
      return "engine, closed loop: " + outcomeText(row.engine);
    case EpisodesModel::kFirstDivergence:
    case EpisodesModel::kCause:
      return row.parting_step == 0 ? QString("the replay stays within the bound around the reference")
                                   : "the replay is beyond the bound around the reference after " +
                                         seconds(row.parting_step) + "; the reference then: " + row.parting_cause +
                                         "; the first to be elsewhere: " + row.parting_first;
    default:
      return "";
  }
}

QVariant color(const EpisodeRow& row, int column) {
  if (column == EpisodesModel::kReference || column == EpisodesModel::kEngine) {
    const bool success = (column == EpisodesModel::kReference ? row.reference : row.engine).success;
    return QBrush(success ? theme::kGood : theme::kBad);
  }
  return {};
}

int alignment(int column) {
  const bool number =
      column == EpisodesModel::kEpisode || column == EpisodesModel::kSeed || column == EpisodesModel::kFirstDivergence;
  return static_cast<int>((number ? Qt::AlignRight : Qt::AlignLeft) | Qt::AlignVCenter);
}

EpisodeRow::Closed closedFrom(const pusht_msgs::RolloutResult& rollout) {
  return {rollout.success != 0, rollout.steps, rollout.ending, rollout.still_step, rollout.pusher_ending};
}

}  // namespace

EpisodeRow rowFrom(const pusht_msgs::EpisodeResult& result) {
  EpisodeRow row;
  row.episode = result.episode;
  row.seed = result.seed;
  for (const pusht_msgs::RolloutResult& rollout : result.rollouts) {
    if (rollout.mode == "reference_closed") {
      row.reference = closedFrom(rollout);
    } else if (rollout.mode == "engine_closed") {
      row.engine = closedFrom(rollout);
      row.closed_parting_step = rollout.parting_step;
    } else if (rollout.mode == "engine_replay") {
      row.parting_step = rollout.parting_step;
      row.parting_cause = inWords(rollout.parting_cause);
      row.parting_first = inWords(rollout.parting_first);
    } else {
      continue;  // a probe
    }
    row.steps = std::max(row.steps, rollout.steps);
  }
  return row;
}

void EpisodesModel::add(const std::vector<pusht_msgs::EpisodeResult>& results) {
  std::vector<EpisodeRow> fresh;
  for (const pusht_msgs::EpisodeResult& result : results) {
    EpisodeRow row = rowFrom(result);
    const int place = static_cast<int>(rows_.size() + fresh.size());
    const auto [known, is_new] = row_of_episode_.emplace(row.episode, place);
    if (is_new) {
      fresh.push_back(std::move(row));
    } else if (known->second < rowCount()) {
      rows_[static_cast<std::size_t>(known->second)] = std::move(row);
      Q_EMIT dataChanged(index(known->second, 0), index(known->second, kColumns - 1));
    } else {
      fresh[static_cast<std::size_t>(known->second) - rows_.size()] = std::move(row);
    }
  }
  if (!fresh.empty()) {
    beginInsertRows({}, rowCount(), rowCount() + static_cast<int>(fresh.size()) - 1);
    std::move(fresh.begin(), fresh.end(), std::back_inserter(rows_));
    endInsertRows();
  }
}

void EpisodesModel::clear() {
  beginResetModel();
  rows_.clear();
  row_of_episode_.clear();
  endResetModel();
}

std::optional<int> EpisodesModel::rowOfEpisode(std::uint64_t episode) const {
  const auto place = row_of_episode_.find(episode);
  return place == row_of_episode_.end() ? std::nullopt : std::optional(place->second);
}

int EpisodesModel::rowCount(const QModelIndex& parent) const {
  return parent.isValid() ? 0 : static_cast<int>(rows_.size());
}

int EpisodesModel::columnCount(const QModelIndex& parent) const { return parent.isValid() ? 0 : kColumns; }

QVariant EpisodesModel::data(const QModelIndex& index, int role) const {
  if (!index.isValid() || index.row() >= rowCount()) {
    return {};
  }
  const EpisodeRow& shown = row(index.row());
  switch (role) {
    case Qt::DisplayRole:
      return text(shown, index.column());
    case Qt::ToolTipRole:
      return toolTip(shown, index.column());
    case Qt::ForegroundRole:
      return color(shown, index.column());
    case Qt::TextAlignmentRole:
      return alignment(index.column());
    default:
      return {};
  }
}

QVariant EpisodesModel::headerData(int section, Qt::Orientation orientation, int role) const {
  constexpr std::array<const char*, kColumns> kHeads = {"#", "seed", "reference", "engine", "parts", "while"};
  constexpr std::array<const char*, kColumns> kTips = {"index of the episode in the run",
                                                       "spawn seed: 10000 + the run's seed + the episode's index",
                                                       "the policy in the reference, closed loop",
                                                       "the policy in the engine, closed loop",
                                                       "when the replay leaves the bound around the reference",
                                                       "what the reference did then"};
  if (orientation != Qt::Horizontal || section < 0 || section >= kColumns) {
    return {};
  }
  if (role == Qt::DisplayRole) {
    return QString(kHeads.at(static_cast<std::size_t>(section)));
  }
  if (role == Qt::TextAlignmentRole) {
    return alignment(section);
  }
  return role == Qt::ToolTipRole ? QVariant(QString(kTips.at(static_cast<std::size_t>(section)))) : QVariant();
}

}  // namespace pusht_rviz
