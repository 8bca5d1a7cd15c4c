// SPDX-License-Identifier: BSD-3-Clause
/// Colours and shapes of the panel; they go with those of the 3D scene.
#pragma once

#include <QColor>
#include <QIcon>
#include <QString>
#include <QWidget>

namespace pusht_rviz::theme {

inline const QColor kReference(0x5A, 0xAA, 0xFF);
inline const QColor kEngine(0xF0, 0xDC, 0x46);
inline const QColor kReplay(0xEE, 0x66, 0x77);
inline const QColor kBackground(0x14, 0x17, 0x1D);
inline const QColor kPaper(0x1F, 0x24, 0x2E);
inline const QColor kBright(0xF4, 0xF4, 0xF2);
inline const QColor kDim(0xA7, 0xB0, 0xC0);
inline const QColor kAxis(0x7A, 0x84, 0x96);
inline const QColor kGrid(0x3A, 0x41, 0x50);
inline const QColor kGood(0x6C, 0xD3, 0xA0);
inline const QColor kBad(0xFF, 0x9D, 0x6B);  ///< apart from kGood for colour-blind readers, too

/// Length or size of a font [px] as on a screen of 1366 pixels, on the screen that is there: up to 1.25 times larger.
int px(int length);

/// Of the whole panel.
QString styleSheet();

/// Shows that what stands in a field breaks a rule.
void mark(QWidget* field, bool wrong);

/// What the large buttons show.
enum class Shape { kStart, kPlay, kPause, kStep, kStop };  ///< kStart: a play sign on the colour of `Start`
/// Icon of a large button.
QIcon icon(Shape shape);

}  // namespace pusht_rviz::theme
