// SPDX-License-Identifier: BSD-3-Clause
#include "theme.hpp"

#include <QGuiApplication>
#include <QPainter>
#include <QPixmap>
#include <QPolygonF>
#include <QScreen>
#include <algorithm>
#include <cmath>

namespace pusht_rviz::theme {
namespace {

constexpr int kIconSize = 32;  // [px] of a drawing of 16 x 16 units

QPixmap drawn(Shape shape, const QColor& color) {
  QPixmap pixmap(kIconSize, kIconSize);
  pixmap.fill(Qt::transparent);
  QPainter painter(&pixmap);
  painter.setRenderHint(QPainter::Antialiasing);
  painter.scale(2.0, 2.0);
  painter.setPen(Qt::NoPen);
  painter.setBrush(color);
  switch (shape) {
    case Shape::kStart:
    case Shape::kPlay:
      painter.drawPolygon(QPolygonF({{3.0, 2.0}, {14.0, 8.0}, {3.0, 14.0}}));
      break;
    case Shape::kPause:
      painter.drawRect(3, 2, 4, 12);
      painter.drawRect(9, 2, 4, 12);
      break;
    case Shape::kStep:
      painter.drawPolygon(QPolygonF({{2.0, 2.0}, {10.0, 8.0}, {2.0, 14.0}}));
      painter.drawRect(11, 2, 3, 12);
      break;
    case Shape::kStop:
      painter.drawRect(3, 3, 10, 10);
      break;
  }
  return pixmap;
}

}  // namespace

int px(int length) {
  constexpr double kWidth = 1366.0;  // [px] of the screen that lengths are given for
  const QScreen* const screen = QGuiApplication::primaryScreen();
  const double scale = screen == nullptr ? 1.0 : std::clamp(screen->size().width() / kWidth, 1.0, 1.25);
  return static_cast<int>(std::lround(scale * length));
}

QString styleSheet() {
  QString sheet = R"(
    QWidget { background: @paper; color: @ink; font-size: 13px; }
    QLabel { background: transparent; }
    QLabel[dim="true"] { color: @dim; font-size: 12px; }
    QLabel[head="true"] { color: @ink; font-weight: bold; }
    QLabel#headline { color: @ink; font-size: 15px; font-weight: bold; padding: 4px 6px; background: @card;
                      border-left: 3px solid @reference; }
    QLabel#status { color: @bad; background: @card; border-left: 3px solid @bad; padding: 4px; }
    QToolTip { background: @card; color: @ink; border: 1px solid @axis; font-size: 13px; }

    QPushButton, QToolButton { background: @card; border: 1px solid @grid; border-radius: 4px; padding: 4px 6px; }
    QToolButton { padding: 0 6px; }
    QPushButton:hover:enabled, QToolButton:hover:enabled { border-color: @dim; }
    QPushButton:pressed, QToolButton:pressed, QPushButton:checked { background: @grid; }
    QPushButton:disabled, QToolButton:disabled { color: @axis; background: @paper; }
    QPushButton:focus, QComboBox:focus, QLineEdit:focus, QTableView:focus { border-color: @reference; }
    QPushButton#start:enabled { background: @reference; color: @paper; border-color: @reference;
                                font-weight: bold; }
    QPushButton[large="true"] { min-height: 24px; padding: 4px 2px; }

    QLineEdit, QComboBox { background: @card; border: 1px solid @grid; border-radius: 3px; padding: 2px 4px;
                           min-height: 20px; selection-background-color: @reference;
                           selection-color: @paper; }
    QLineEdit:disabled, QComboBox:disabled { color: @axis; background: @paper; }
    QComboBox QAbstractItemView { background: @card; border: 1px solid @axis; selection-background-color: @grid;
                                  selection-color: @ink; }
    QTreeView { background: @card; alternate-background-color: @stripe; border: 1px solid @grid;
                selection-background-color: @grid; selection-color: @ink; }
    QTreeView::item { min-height: 22px; }
    QTreeView::item:selected { background: @grid; color: @ink; }
    QTreeView::indicator { width: 14px; height: 14px; border: 1px solid @axis; border-radius: 2px; background: @paper; }
    QTreeView::indicator:checked { background: @reference; border-color: @ink; }
    QTreeView QLineEdit, QTreeView QComboBox { min-height: 0; padding: 0 2px; background: @paper; }

    QProgressBar { background: @card; border: 1px solid @grid; border-radius: 3px; text-align: center;
                   min-height: 22px; font-size: 12px; }
    QProgressBar::chunk { background: @selected; }
    QSlider::groove:horizontal { background: @grid; height: 6px; border-radius: 3px; }
    QSlider::sub-page:horizontal { background: @selected; border-radius: 3px; }
    QSlider::handle:horizontal { background: @ink; width: 12px; margin: -6px 0; border-radius: 6px; }

    QTabWidget::pane { border: 0; border-top: 1px solid @grid; }
    QTabBar::tab { background: @paper; color: @dim; padding: 5px 12px; border: 0;
                   border-bottom: 2px solid transparent; }
    QTabBar::tab:selected { color: @ink; border-bottom: 2px solid @reference; }
    QTabBar::tab:hover { color: @ink; }
    QScrollArea { border: 0; }

    QTableView { background: @card; alternate-background-color: @stripe; gridline-color: @grid;
                 border: 1px solid @grid; selection-background-color: @grid; selection-color: @ink;
                 font-size: 12px; }
    QHeaderView::section { background: @paper; color: @dim; border: 0; border-bottom: 1px solid @grid;
                           padding: 3px 4px; font-size: 12px; }
    QTableCornerButton::section { background: @paper; border: 0; }
    QScrollBar:vertical { background: @paper; width: 12px; margin: 0; }
    QScrollBar:horizontal { background: @paper; height: 12px; margin: 0; }
    QScrollBar::handle { background: @grid; border-radius: 4px; min-height: 24px; min-width: 24px; margin: 2px; }
    QScrollBar::handle:hover { background: @axis; }
    QScrollBar::add-line, QScrollBar::sub-line { width: 0; height: 0; }
    QScrollBar::add-page, QScrollBar::sub-page { background: transparent; }
  )";
  for (const auto& [name, color] :
       {std::pair("@reference", kReference), std::pair("@paper", kPaper), std::pair("@card", kCard),
        std::pair("@stripe", kStripe), std::pair("@ink", kInk), std::pair("@dim", kDim), std::pair("@axis", kAxis),
        std::pair("@grid", kGrid), std::pair("@bad", kBad), std::pair("@selected", kSelected)}) {
    sheet.replace(name, color.name());
  }
  for (const int size : {12, 13, 15}) {
    sheet.replace("font-size: " + QString::number(size) + "px", "font-size: @" + QString::number(px(size)) + "px");
  }
  return sheet.replace("font-size: @", "font-size: ");
}

QIcon icon(Shape shape) {
  QIcon icon(drawn(shape, shape == Shape::kStart ? kPaper : kInk));
  icon.addPixmap(drawn(shape, kAxis), QIcon::Disabled);
  return icon;
}

}  // namespace pusht_rviz::theme
