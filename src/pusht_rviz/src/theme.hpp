// SPDX-License-Identifier: BSD-3-Clause
/// Look of the panel. Its colors are those of the 3D scene.
#pragma once

#include <QColor>
#include <QIcon>
#include <QString>

#include "pusht_task/palette.hpp"

namespace pusht_rviz::theme {

inline const QColor kReference(pusht::palette::kReference);
inline const QColor kEngine(pusht::palette::kEngine);
inline const QColor kReplay(pusht::palette::kReplay);
inline const QColor kPaper(pusht::palette::kPaper);  ///< background
inline const QColor kCard(pusht::palette::kCard);    ///< background of fields, tables and plots
inline const QColor kStripe(pusht::palette::kStripe);
inline const QColor kInk(pusht::palette::kInk);
inline const QColor kDim(pusht::palette::kDim);
inline const QColor kAxis(pusht::palette::kAxis);
inline const QColor kGrid(pusht::palette::kGrid);
inline const QColor kSelected(pusht::palette::kSelected);
inline const QColor kGood(pusht::palette::kGood);
inline const QColor kBad(pusht::palette::kBad);

/// Length or font size [px] on the screen that is there, given one for a screen 1366 px wide: the same, or up to 1.25
/// times as large on a wider screen.
int px(int length);

/// Style sheet of the whole panel.
QString styleSheet();

/// Signs on the large buttons. kStart is a play sign on the color of the button Start.
enum class Shape { kStart, kPlay, kPause, kStep, kStop };
/// Icon of a large button.
QIcon icon(Shape shape);

}  // namespace pusht_rviz::theme
