// SPDX-License-Identifier: BSD-3-Clause
#include "episode_list.hpp"

#include <QHeaderView>
#include <QVBoxLayout>
#include <array>
#include <cstddef>

#include "theme.hpp"

namespace pusht_rviz {

EpisodeList::EpisodeList(EpisodesModel* episodes, QWidget* parent)
    : QWidget(parent), episodes_(episodes), table_(new QTableView(this)), go_(new QPushButton(this)) {
  go_->setObjectName("go_to_episode");
  table_->setObjectName("episode_list");
  table_->setModel(episodes);
  table_->setSelectionBehavior(QAbstractItemView::SelectRows);
  table_->setSelectionMode(QAbstractItemView::SingleSelection);
  table_->setAlternatingRowColors(true);
  table_->setShowGrid(false);
  table_->setWordWrap(false);
  table_->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);  // tool tips show what is cut off
  // Fixed heights and widths, so that the layout never looks at ten thousand rows.
  table_->verticalHeader()->hide();
  table_->verticalHeader()->setSectionResizeMode(QHeaderView::Fixed);
  table_->verticalHeader()->setDefaultSectionSize(theme::px(22));
  table_->horizontalHeader()->setMinimumSectionSize(24);
  table_->horizontalHeader()->setSectionResizeMode(EpisodesModel::kCause, QHeaderView::Stretch);
  constexpr std::array kWidths = {34, 50, 72, 64, 44};
  for (std::size_t i = 0; i < kWidths.size(); ++i) {
    table_->setColumnWidth(static_cast<int>(i), theme::px(kWidths.at(i)));
  }
  auto* const all = new QVBoxLayout(this);
  all->setContentsMargins(0, 6, 0, 0);
  all->setSpacing(4);
  all->addWidget(table_, 1);
  all->addWidget(go_);
  setReplay(false);
  connect(table_, &QTableView::doubleClicked, this, &EpisodeList::choose);
  connect(go_, &QPushButton::clicked, this, [this] { choose(table_->currentIndex()); });
}

void EpisodeList::setReplay(bool replay) {
  go_->setText(replay ? "Go to this episode" : "Show the curves of this episode");
}

void EpisodeList::choose(const QModelIndex& index) {
  if (index.isValid() && index.row() < episodes_->rowCount()) {
    Q_EMIT chosen(episodes_->row(index.row()).episode);
  }
}

}  // namespace pusht_rviz
