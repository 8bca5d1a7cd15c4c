// SPDX-License-Identifier: BSD-3-Clause
/// Form built from descriptors of parameters, of a simulator or of a run.
#pragma once

#include <QLabel>
#include <QString>
#include <QToolButton>
#include <QWidget>
#include <cstddef>
#include <functional>
#include <vector>

#include "parameter_draft.hpp"

namespace pusht_rviz {

/// A row for each parameter: name (marked where it differs from its base), a check box, a list of words or a text
/// field, unit, a button that takes the value back, and below them the rule that the value breaks. It knows no
/// parameter by name. Object names of the controls: prefix + NAME, with ".reset" and ".refusal" for the last two.
class ParameterForm : public QWidget {
  Q_OBJECT

 public:
  explicit ParameterForm(QString prefix, QWidget* parent = nullptr);

  /// Replaces all rows. Emits changed().
  void build(const ParameterDraft& draft);

  /// Puts a text into the field of a parameter, if there is one of that name. Emits nothing.
  void setText(const QString& name, const QString& text);

  const ParameterDraft& draft() const { return draft_; }

 Q_SIGNALS:
  void changed();

 private:
  struct Row {
    QLabel* name = nullptr;
    QWidget* editor = nullptr;
    QToolButton* reset = nullptr;
    QLabel* refusal = nullptr;
    std::function<void(const QString&)> show;  ///< puts a text into the editor
  };

  void addRow(const DraftedParameter& drafted);
  void makeEditor(Row& row, const pusht_msgs::ParameterDescriptor& descriptor);
  void edit(std::size_t index, const QString& text);
  void type(std::size_t index, const QString& text);
  void show(std::size_t index);
  void mark(std::size_t index);

  QString prefix_;
  QWidget* grid_;  // parent of all controls, replaced with them
  ParameterDraft draft_;
  std::vector<Row> rows_;  // of its parameters
};

}  // namespace pusht_rviz
