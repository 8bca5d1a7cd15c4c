// SPDX-License-Identifier: BSD-3-Clause
/// Finished episodes as a table.
#pragma once

#include <pusht_msgs/EpisodeResult.h>

#include <QAbstractTableModel>
#include <QString>
#include <QVariant>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace pusht_rviz {

/// One finished episode.
struct EpisodeRow {
  /// Closed loop of a role.
  struct Closed {
    bool success = false;
    std::uint32_t steps = 0;
    std::string ending{};          ///< as in RolloutResult.msg
    std::uint32_t still_step = 0;  ///< control steps after which its tee stays where it ends
    std::string pusher_ending{};
  };

  std::uint64_t episode = 0;
  std::uint64_t seed = 0;   ///< spawn seed; 0: the initial state came from a file
  std::uint32_t steps = 0;  ///< of the longest of the three rollouts
  Closed reference{};
  Closed engine{};
  std::uint32_t parting_step = 0;         ///< first divergence of the replay; 0: it stays within the bound
  std::uint32_t closed_parting_step = 0;  ///< the same for the engine in closed loop
  QString parting_cause;                  ///< of the replay, in words
  QString parting_first;                  ///< body that leaves the reference first, in words
};

/// Row of the table for a finished episode.
EpisodeRow rowFrom(const pusht_msgs::EpisodeResult& result);

/// Rows in the order in which episodes finished. To add one takes the same time whatever their number.
class EpisodesModel : public QAbstractTableModel {
  Q_OBJECT

 public:
  enum Column { kEpisode, kSeed, kReference, kEngine, kFirstDivergence, kCause, kColumns };

  using QAbstractTableModel::QAbstractTableModel;

  /// Adds episodes. One that is there already, since it was run again or asked for late, is replaced.
  void add(const std::vector<pusht_msgs::EpisodeResult>& results);
  void clear();

  const EpisodeRow& row(int index) const { return rows_.at(static_cast<std::size_t>(index)); }
  std::optional<int> rowOfEpisode(std::uint64_t episode) const;

  int rowCount(const QModelIndex& parent = {}) const override;
  int columnCount(const QModelIndex& parent = {}) const override;
  QVariant data(const QModelIndex& index, int role) const override;
  QVariant headerData(int section, Qt::Orientation orientation, int role) const override;

 private:
  std::vector<EpisodeRow> rows_;
  std::unordered_map<std::uint64_t, int> row_of_episode_;
};

}  // namespace pusht_rviz
