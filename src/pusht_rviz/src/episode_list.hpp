// SPDX-License-Identifier: BSD-3-Clause
/// Table of the finished episodes, with a button that goes to one.
#pragma once

#include <QPushButton>
#include <QTableView>
#include <QWidget>

#include "episodes_model.hpp"

namespace pusht_rviz {

/// Object names: episode_list, go_to_episode.
class EpisodeList : public QWidget {
  Q_OBJECT

 public:
  /// `episodes` must outlive the list.
  explicit EpisodeList(EpisodesModel* episodes, QWidget* parent = nullptr);

  void select(int row) { table_->selectRow(row); }
  void setReplay(bool replay);

 Q_SIGNALS:
  void chosen(std::uint64_t episode);  ///< by the button or a double click

 private:
  void choose(const QModelIndex& index);

  EpisodesModel* episodes_;
  QTableView* table_;
  QPushButton* go_;
};

}  // namespace pusht_rviz
