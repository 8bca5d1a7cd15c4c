// SPDX-License-Identifier: BSD-3-Clause
/// Parameters of a simulator, or options of a run, as a form has them while they are edited. Without widgets.
#pragma once

#include <pusht_msgs/DescribeResponse.h>
#include <pusht_msgs/Parameter.h>
#include <pusht_msgs/ParameterDescriptor.h>
#include <pusht_msgs/RunOptions.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace pusht_rviz {

/// Rule that `text` breaks as a value of this parameter, with name and text; empty: it breaks none.
std::string refusalOf(const pusht_msgs::ParameterDescriptor& parameter, const std::string& text);

/// Values that a parameter takes, in words: "from 0.0 to 100.0 [1/s]"; empty: all of its type.
std::string rangeOf(const pusht_msgs::ParameterDescriptor& parameter);

/// Text of the last parameter of that name; none if there is none.
std::optional<std::string> textAmong(const std::vector<pusht_msgs::Parameter>& parameters, const std::string& name);

/// One parameter with the text that is in its field.
struct DraftedParameter {
  pusht_msgs::ParameterDescriptor descriptor;
  std::string initial;  ///< value unless a goal names it or a preset sets it: a kind's default, an evaluator's option,
                        ///< or what a node without descriptors said first
  std::string base;     ///< value unless a goal names it: `initial`, or what a preset that the goal names sets
  std::string text;     ///< value that is wanted
  bool always_named = false;  ///< its default is not known, so a goal must name it

  /// Whether `text` stands for another value than `base`: 6 and 6.0 are one real number.
  bool differs() const;
};

/// All parameters of a form, in its order.
class ParameterDraft {
 public:
  ParameterDraft() = default;

  /// Parameters of a simulator, from its defaults; `chosen` is written over the texts of the parameters of those names.
  ParameterDraft(const pusht_msgs::DescribeResponse& simulator, const std::vector<pusht_msgs::Parameter>& chosen);

  /// Options of a run, from the values that an evaluator uses where a goal leaves them open.
  explicit ParameterDraft(const pusht_msgs::RunOptions& options);

  /// Puts a text into a field. If it is a word with a preset, the parameters of the preset follow, unless they differ
  /// from their base already.
  void type(std::size_t index, const std::string& text);

  /// What a goal must name so that a run uses what is shown.
  std::vector<pusht_msgs::Parameter> named() const;

  /// Index of the parameter `name`; none if there is none.
  std::optional<std::size_t> find(const std::string& name) const;

  std::size_t size() const { return parameters_.size(); }
  const DraftedParameter& operator[](std::size_t index) const { return parameters_.at(index); }
  auto begin() const { return parameters_.begin(); }
  auto end() const { return parameters_.end(); }

 private:
  void rebase();

  std::vector<DraftedParameter> parameters_;
};

}  // namespace pusht_rviz
