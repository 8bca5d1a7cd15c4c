// SPDX-License-Identifier: BSD-3-Clause
#include "simulator_form.hpp"

#include <gmock/gmock.h>

#include <QEvent>
#include <QLineEdit>
#include <string>

#include "headless.hpp"
#include "parameters.hpp"

namespace pusht_rviz {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// What a node says that can be one kind, with a parameter of default 6 and one that has no descriptor.
pusht_msgs::DescribeResponse nodeWith(const std::string& damp, const std::string& gain) {
  pusht_msgs::DescribeResponse made;
  made.success = 1;
  made.name = "springy";
  made.parameters = {parameter("damp", damp), parameter("gain", gain)};
  pusht_msgs::ParameterDescriptor described;
  described.name = "damp";
  described.type = "real";
  described.default_value = "6.0";
  described.least = 0.0;
  described.greatest = 100.0;
  made.parameter_descriptors = {described};
  return made;
}

class SimulatorFormTest : public testing::Test {
 protected:
  template <class Widget>
  Widget* find(const QString& name) {
    QApplication::sendPostedEvents(nullptr, QEvent::DeferredDelete);  // those of the form before
    return form_.findChild<Widget*>(name);
  }
  void type(const char* name, const char* text) { find<QLineEdit>(name)->setText(text); }
  QString shown(const char* name) { return find<QLineEdit>(name)->text(); }
  /// Whether a field is marked: its value can be taken back.
  bool marked(const char* name) { return find<QToolButton>(QString(name) + ".reset")->isEnabled(); }

  QApplication& application_ = headlessApplication();
  SimulatorForm form_{"engine"};
};

TEST_F(SimulatorFormTest, SendsWhatItShowsWhateverARunMadeOfTheNode) {
  form_.setRequest("", {});
  form_.setNode(nodeWith("6.0", "1"));
  type("engine.damp", "20");
  const std::vector<pusht_msgs::Parameter> wanted = {parameter("damp", "20"), parameter("gain", "1")};
  EXPECT_EQ(form_.draft().kind, "springy");
  EXPECT_EQ(form_.draft().parameters.named(), wanted);
  form_.setNode(nodeWith("20.0", "1"));  // after the run
  EXPECT_EQ(shown("engine.damp"), "20");
  EXPECT_EQ(form_.draft().parameters.named(), wanted) << "a run inherits nothing from the one before";
  type("engine.damp", "6");
  EXPECT_THAT(form_.draft().parameters.named(), ElementsAre(parameter("gain", "1")))
      << "the default of the kind that is named";
}

TEST_F(SimulatorFormTest, MarksWhatWasChangedWhateverARunMadeOfTheNode) {
  form_.setNode(nodeWith("6.0", "1"));
  EXPECT_FALSE(marked("engine.damp"));
  EXPECT_FALSE(marked("engine.gain"));
  type("engine.damp", "20");
  type("engine.gain", "2");
  for (const auto& node : {nodeWith("6.0", "1"), nodeWith("20.0", "2")}) {
    form_.setNode(node);
    EXPECT_TRUE(marked("engine.damp"));
    EXPECT_TRUE(marked("engine.gain"));
  }
}

TEST_F(SimulatorFormTest, BeginsWithWhatTheEvaluatorAsksFor) {
  form_.setRequest("", {parameter("damp", "8")});
  form_.setNode(nodeWith("20.0", "3"));
  EXPECT_THAT(form_.draft().parameters.named(), ElementsAre(parameter("damp", "8"), parameter("gain", "3")));
  form_.setRequest("", {});
  EXPECT_THAT(form_.draft().parameters.named(), ElementsAre(parameter("damp", "20.0"), parameter("gain", "3")))
      << "else with what the node has";
  form_.setRequest("springy", {});
  EXPECT_EQ(shown("engine.damp"), "6.0") << "a kind that is named has its defaults";
}

TEST_F(SimulatorFormTest, IsBuiltAnewForAnotherSimulator) {
  form_.setNode(nodeWith("6.0", "1"));
  type("engine.damp", "20");
  pusht_msgs::DescribeResponse other = nodeWith("6.0", "1");
  other.name = "stiff";
  form_.setNode(other);
  EXPECT_EQ(form_.draft().kind, "stiff");
  EXPECT_EQ(shown("engine.damp"), "6.0");
  form_.forget();
  EXPECT_THAT(form_.draft().parameters.named(), IsEmpty());
}

}  // namespace
}  // namespace pusht_rviz
