// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/model_variants.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "pusht_mujoco/mujoco_kind.hpp"
#include "pusht_task/error.hpp"

namespace sim2sim {
namespace {

using ::testing::HasSubstr;
using Variants = std::vector<std::string>;

/// Model variants by name, of MuJoCo with `changes`.
Variants namedWith(const std::vector<std::pair<std::string, std::string>>& changes, const Variants& asked,
                   pusht::SimulatorKind kind = pusht::mujocoKind()) {
  pusht::ParameterSet reference = kind.defaults();
  for (const auto& [name, value] : changes) {
    reference.set(name, value);
  }
  RunOptions options;
  options.model_variants = asked;
  options.closed_variants = asked;
  nameVariants(kind, reference, options);
  EXPECT_EQ(options.closed_variants, options.model_variants);
  return options.model_variants;
}

std::string refusalOf(const Variants& asked, const pusht::SimulatorKind& kind = pusht::mujocoKind()) {
  try {
    namedWith({}, asked, kind);
  } catch (const pusht::InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(ModelVariants, AreNamedByTheirParametersAsTheKindReadsThem) {
  EXPECT_EQ(namedWith({}, {"timestep=5e-3", "cone=elliptic:timestep=0.001"}),
            (Variants{"timestep=0.005", "cone=elliptic:timestep=0.001"}));
}

TEST(ModelVariants, OfOneListAreDifferentModels) {
  EXPECT_THAT(refusalOf({"timestep=0.005", "timestep=5e-3"}), HasSubstr("timestep=0.005: is named twice"));
  EXPECT_THAT(refusalOf({"cone=elliptic:timestep=0.005", "timestep=0.005:cone=elliptic"}),
              HasSubstr("timestep=0.005:cone=elliptic: is the same model as cone=elliptic:timestep=0.005"));
  EXPECT_THAT(refusalOf({"timestep=0.005", "timestep=0.005:integrator=implicit"}),
              HasSubstr("timestep=0.005:integrator=implicit: is the same model as timestep=0.005"));
  EXPECT_THAT(refusalOf({"integrator=implicit"}), HasSubstr("must differ from the reference"));
  EXPECT_EQ(refusalOf({"timestep=0.005", "timestep=0.005:integrator=Euler"}), "");
}

TEST(ModelVariants, SetAParameterOnce) {
  EXPECT_THAT(
      refusalOf({"timestep=0.005:timestep=0.001"}),
      HasSubstr("timestep=0.005:timestep=0.001: of the reference mujoco: parameter timestep: must be set once"));
}

TEST(ModelVariants, ByDefaultLeaveOutTheReferenceItself) {
  const pusht::SimulatorKind& mujoco = pusht::mujocoKind();
  ASSERT_EQ(mujoco.variants.front(), "timestep=0.005");
  const Variants rest(mujoco.variants.begin() + 1, mujoco.variants.end());
  EXPECT_EQ(namedWith({}, {kDefaultVariants}), mujoco.variants);
  EXPECT_EQ(namedWith({{"timestep", "0.005"}}, {kDefaultVariants}), rest);
  pusht::SimulatorKind one = mujoco;
  one.variants = {"timestep=0.01"};
  EXPECT_THAT(refusalOf({kDefaultVariants}, one), HasSubstr("the reference mujoco has none but itself; name them"));
  one.variants.clear();
  EXPECT_THAT(refusalOf({kDefaultVariants}, one), HasSubstr("the reference mujoco has none; name them"));
}

}  // namespace
}  // namespace sim2sim
