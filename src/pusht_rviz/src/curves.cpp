// SPDX-License-Identifier: BSD-3-Clause
#include "curves.hpp"

#include <qcustomplot.h>

#include <QFontMetrics>
#include <QVBoxLayout>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "theme.hpp"

namespace pusht_rviz {
namespace {

constexpr int kRedrawPeriod = 70;      // [ms]
constexpr double kShortestAxis = 5.0;  // [s]
constexpr int kFaded = 56;             // opacity of earlier episodes, of 255
constexpr double kGap = std::numeric_limits<double>::quiet_NaN();

constexpr std::array<double, kAspects> kLeast = {1e-5, 1e-4};    // of the axes, [m] and [rad]
constexpr std::array<double, kAspects> kGreatest = {1.0, 3.15};  // a greater value is drawn at the top

constexpr std::array<const char*, kAspects> kTitles = {"position apart [m]", "angle apart [rad]"};
constexpr std::array<const char*, kCurveKinds> kNames = {"same actions", "same policy", "tee that never moves"};

QColor colorOf(std::size_t kind) {
  return kind == kReplayCurve ? theme::kReplay : kind == kClosedCurve ? theme::kEngine : theme::kDim;
}

QFont small() {
  QFont made;
  made.setPixelSize(theme::px(12));
  return made;
}

/// Value clamped to the range of the logarithmic axis; NaN stays.
double shown(double value, std::size_t aspect) {
  return std::isnan(value) ? value : std::clamp(value, kLeast.at(aspect), kGreatest.at(aspect));
}

}  // namespace

Curves::Curves(QWidget* parent) : QWidget(parent), plot_(new QCustomPlot(this)) {
  auto* const all = new QVBoxLayout(this);
  all->setContentsMargins(0, 0, 0, 0);
  all->addWidget(plot_);
  plot_->setObjectName("curves");
  plot_->setMinimumHeight(theme::px(180));
  plot_->setBackground(QBrush(theme::kPaper));
  plot_->setNoAntialiasingOnDrag(true);
  plot_->plotLayout()->clear();
  plot_->plotLayout()->setRowSpacing(2);
  // The layer has a buffer of its own, so redrawing it leaves axes and earlier episodes as they are.
  plot_->addLayer("live", plot_->layer("main"), QCustomPlot::limAbove);
  live_ = plot_->layer("live");
  live_->setMode(QCPLayer::lmBuffered);
  build(kPosition);
  build(kAngle);

  auto* const legend = new QCPLegend;
  plot_->plotLayout()->addElement(static_cast<int>(kAspects), 0, legend);
  plot_->plotLayout()->setRowStretchFactor(static_cast<int>(kAspects), 0.001);
  legend->setFont(small());
  legend->setTextColor(theme::kDim);
  legend->setBrush(Qt::NoBrush);
  legend->setBorderPen(Qt::NoPen);
  legend->setFillOrder(QCPLegend::foColumnsFirst);
  legend->setMargins(QMargins(4, 0, 4, 2));
  legend->setIconSize(18, 14);
  legend->setLayer("legend");
  legend->setColumnSpacing(6);
  legend->setWrap(2);
  for (QCPGraph* const graph : charts_[kPosition].now) {
    graph->addToLegend(legend);
  }
  charts_[kPosition].floor->addToLegend(legend);

  connect(&timer_, &QTimer::timeout, this, &Curves::redraw);
  timer_.start(kRedrawPeriod);
}

void Curves::build(Aspect aspect) {
  Chart& chart = charts_.at(aspect);
  chart.rect = new QCPAxisRect(plot_, false);
  plot_->plotLayout()->addElement(static_cast<int>(aspect), 0, chart.rect);
  chart.rect->setLayer("background");
  chart.rect->addAxes(QCPAxis::atLeft | QCPAxis::atBottom);
  chart.rect->setBackground(QBrush(theme::kCard));
  chart.rect->setMinimumMargins(QMargins(4, 6, 8, 2));
  for (QCPAxis* const axis : chart.rect->axes()) {
    axis->setBasePen(QPen(theme::kGrid));
    axis->setTickPen(QPen(theme::kGrid));
    axis->setSubTicks(false);
    axis->setTickLength(0, 3);
    axis->setTickLabelFont(small());
    axis->setTickLabelColor(theme::kDim);
    axis->grid()->setPen(QPen(theme::kGrid, 0.0, Qt::DotLine));
    axis->grid()->setVisible(true);
    axis->grid()->setZeroLinePen(Qt::NoPen);
    axis->grid()->setLayer("grid");
    axis->setLayer("axes");
  }
  QCPAxis* const time = chart.rect->axis(QCPAxis::atBottom);
  QCPAxis* const value = chart.rect->axis(QCPAxis::atLeft);
  value->setScaleType(QCPAxis::stLogarithmic);
  const QSharedPointer<QCPAxisTickerLog> decades(new QCPAxisTickerLog);
  decades->setTickCount(4);
  connect(plot_, &QCustomPlot::afterReplot, this, [this, rect = chart.rect, decades, aspect] {
    // Labels of all decades would touch on a low plot: then every second one has a label. Heights are known once the
    // plot is laid out.
    const double decade = rect->height() / std::log10(kGreatest.at(aspect) / kLeast.at(aspect));
    const double base = decade < QFontMetrics(small()).height() ? 100.0 : 10.0;
    if (decades->logBase() != base) {
      decades->setLogBase(base);
      plot_->replot(QCustomPlot::rpQueuedReplot);
    }
  });
  decades->setSubTickCount(0);
  value->setTicker(decades);
  value->setNumberFormat("eb");
  value->setNumberPrecision(0);
  value->setRange(kLeast.at(aspect), kGreatest.at(aspect));
  if (aspect == kAngle) {
    time->setLabel("time [s]");
    time->setLabelFont(small());
    time->setLabelColor(theme::kDim);
    time->setLabelPadding(0);
  } else {
    time->setTickLabels(false);
  }
  auto* const margins =
      aspect == kPosition ? new QCPMarginGroup(plot_) : charts_[kPosition].rect->marginGroup(QCP::msLeft);
  chart.rect->setMarginGroup(QCP::msLeft, margins);

  chart.bound = plot_->addGraph(time, value);
  chart.bound->setPen(QPen(theme::kInk, 1.0, Qt::DotLine));
  chart.bound->setAntialiased(false);
  chart.floor = plot_->addGraph(time, value);
  chart.floor->setName("reference from itself (floor)");
  chart.floor->setPen(QPen(theme::kReference, 1.0, Qt::DashDotLine));
  chart.floor->setAntialiased(false);
  chart.cursor = new QCPItemStraightLine(plot_);
  chart.cursor->setPen(QPen(theme::kInk, 1.0));
  chart.cursor->setAntialiased(false);
  chart.cursor->setClipAxisRect(chart.rect);
  for (QCPItemPosition* const end : {chart.cursor->point1, chart.cursor->point2}) {
    end->setAxisRect(chart.rect);
    end->setAxes(time, value);
  }
  chart.cursor->setLayer(live_);
  chart.cursor->setVisible(false);
  for (const std::size_t kind : {kClosedCurve, kReplayCurve}) {
    QColor faded = colorOf(kind);
    faded.setAlpha(kFaded);
    chart.earlier[kind] = new QCPCurve(time, value);
    chart.earlier[kind]->setPen(QPen(faded, 1.0));
    chart.earlier[kind]->setAntialiased(false);
  }
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    chart.now[kind] = plot_->addGraph(time, value);
    chart.now[kind]->setName(kNames.at(kind));
    chart.now[kind]->setPen(kind == kNullCurve ? QPen(theme::kDim, 1.0, Qt::DashLine) : QPen(colorOf(kind), 2.0));
    chart.now[kind]->setLayer(live_);
  }
  chart.title = new QCPItemText(plot_);
  chart.title->setFont(small());
  chart.title->setColor(theme::kInk);
  chart.title->setBrush(QBrush(theme::kCard));  // curves run below it
  chart.title->setText(kTitles.at(aspect));
  chart.title->setPositionAlignment(Qt::AlignRight | Qt::AlignBottom);
  chart.title->position->setType(QCPItemPosition::ptAxisRectRatio);
  chart.title->position->setAxisRect(chart.rect);
  chart.title->setClipAxisRect(chart.rect);
  chart.title->position->setCoords(0.985, 0.97);
  chart.title->setLayer("overlay");
}

void Curves::add(const pusht_msgs::Divergence& divergence) { store_.add(divergence); }

void Curves::clear() {
  store_.clear();
  chosen_.reset();
}

void Curves::setBound(double position, double angle) {
  bounds_ = {position, angle};
  stale_ = true;
}

void Curves::setFloor(const std::array<double, kAspects>& floor) {
  floor_ = floor;
  stale_ = true;
}

void Curves::setReplay(bool replay) {
  store_.setReplay(replay);
  stale_ = stale_ || replay != replay_;
  replay_ = replay;
}

bool Curves::choose(std::uint64_t episode) {
  if (store_.find(episode) == nullptr) {
    return false;
  }
  chosen_ = episode == store_.current().episode ? std::nullopt : std::optional(episode);
  stale_ = true;
  return true;
}

void Curves::redraw() {
  if (!isVisible() || (!stale_ && store_.version() == drawn_)) {
    return;
  }
  const bool axes = fitAxes();
  const bool earlier = store_.earlierVersion() != drawn_earlier_;
  drawNow();
  if (earlier || stale_) {
    drawEarlier();
  }
  if (axes || earlier || stale_) {
    plot_->replot();
  } else {
    live_->replot();
  }
  drawn_ = store_.version();
  drawn_earlier_ = store_.earlierVersion();
  stale_ = false;
}

bool Curves::fitAxes() {
  bool changed = false;
  const double end = std::max(kShortestAxis, kShortestAxis * std::ceil(store_.end() / kShortestAxis));
  for (const Aspect aspect : {kPosition, kAngle}) {
    Chart& chart = charts_.at(aspect);
    const QCPRange time(0.0, end);
    QCPAxis* const bottom = chart.rect->axis(QCPAxis::atBottom);
    changed = changed || bottom->range() != time;
    bottom->setRange(time);
    chart.bound->setData({0.0, end}, {bounds_.at(aspect), bounds_.at(aspect)}, true);
    const double floor = shown(floor_.at(aspect), aspect);
    chart.floor->setData({0.0, end}, {floor, floor}, true);
  }
  return changed;
}

void Curves::drawNow() {
  const EpisodeCurves* const bright = store_.find(chosen());
  const std::vector<CurvePoint> none;
  const std::vector<CurvePoint>& points = bright == nullptr ? none : bright->points;
  for (const Aspect aspect : {kPosition, kAngle}) {
    Chart& chart = charts_.at(aspect);
    chart.cursor->setVisible(replay_ && !points.empty());
    chart.cursor->point1->setCoords(store_.cursor(), kLeast.at(aspect));
    chart.cursor->point2->setCoords(store_.cursor(), kGreatest.at(aspect));
    chart.title->setText(QString(kTitles.at(aspect)) +
                         (chosen_ ? QString::fromUtf8(" · episode ") + QString::number(*chosen_) : ""));
    for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
      QVector<QCPGraphData> data;
      data.reserve(static_cast<int>(points.size()));
      for (const CurvePoint& point : points) {
        data.append({point.time, shown(point.values.at(kind).at(aspect), aspect)});
      }
      chart.now.at(kind)->data()->set(data, true);
    }
  }
}

void Curves::drawEarlier() {
  for (const Aspect aspect : {kPosition, kAngle}) {
    for (const std::size_t kind : {kReplayCurve, kClosedCurve}) {
      QVector<QCPCurveData> data;
      double order = 0.0;
      for (const EpisodeCurves& curves : store_.earlier()) {
        if (chosen_) {
          break;  // a chosen episode is drawn alone
        }
        for (const CurvePoint& point : curves.points) {
          data.append({order++, point.time, shown(point.values.at(kind).at(aspect), aspect)});
        }
        data.append({order++, kGap, kGap});
      }
      charts_.at(aspect).earlier.at(kind)->data()->set(data, true);
    }
  }
}

}  // namespace pusht_rviz
