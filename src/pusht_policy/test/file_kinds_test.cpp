// SPDX-License-Identifier: BSD-3-Clause
#include "../src/file_kinds.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "pusht_task/files.hpp"
#include "pusht_testing/refusal.hpp"
#include "pusht_testing/temporary_folder.hpp"

namespace pusht {
namespace {

using namespace std::string_literals;
using ::testing::HasSubstr;

constexpr const char* kTaken = "not refused";

std::string refusalOfBytes(const std::string& bytes) {
  return testing::refusalOf([&] { requireNoOtherFormat(bytes, "policy p.pt"); });
}

TEST(FileKinds, SayWhatAFileIs) {
  const std::string zip = "PK\x03\x04";
  EXPECT_THAT(
      refusalOfBytes(zip + "p/data.pkl ... collections OrderedDict"),
      HasSubstr("policy p.pt: must be TorchScript, is weights without their network (a state_dict); in PyTorch"));
  EXPECT_THAT(refusalOfBytes(zip + "p/data.pkl ... __main__ Net"), HasSubstr("is a pickled object (torch.save)"));
  EXPECT_THAT(refusalOfBytes(zip + "p/serialized_exported_program.json"), HasSubstr("is an ExportedProgram"));
  EXPECT_THAT(refusalOfBytes(zip + "p/models/model.json"), HasSubstr("is an ExportedProgram"));
  EXPECT_THAT(refusalOfBytes(zip + "data _stable_baselines3_version policy.pth p/data.pkl"),
              HasSubstr("is a model of Stable-Baselines3"));
  EXPECT_THAT(refusalOfBytes("\x80\x02}q."), HasSubstr("is a pickled object, which needs its Python code"));
  EXPECT_THAT(refusalOfBytes("\x40\0\0\0\0\0\0\0{\"weight\":"s),
              HasSubstr("weights without their network (safetensors)"));
  EXPECT_THAT(refusalOfBytes("\x89HDF\r\n"), HasSubstr("is an HDF5 file"));
  EXPECT_THAT(refusalOfBytes("\x08\x07\x12\x07pytorch"),
              HasSubstr("is an ONNX model, by its first bytes; name it NAME.onnx"));
}

/// What is TorchScript, or nothing known, is left to the reader of archives.
TEST(FileKinds, LeaveOthersAlone) {
  EXPECT_EQ(refusalOfBytes("PK\x03\x04 p/data.pkl p/code/__torch__.py p/constants.pkl"), kTaken);
  EXPECT_EQ(refusalOfBytes("PK\x03\x04 p/data.pkl p/code/__torch__/stable_baselines3/actor.py p/constants.pkl"),
            kTaken);
  EXPECT_EQ(refusalOfBytes("hello"), kTaken);
  EXPECT_EQ(refusalOfBytes(""), kTaken);
}

TEST(FileKinds, AFolderIsNamed) {
  const testing::TemporaryFolder folder;
  const auto refusal = [&] { return testing::refusalOf([&] { requireFile(folder.path(), "policy p"); }); };
  EXPECT_EQ(refusal(), "policy p: must be a readable file, is a folder");
  writeFile(folder / "model.safetensors", kTaken);
  EXPECT_THAT(refusal(), HasSubstr("is a folder with weights without their network (model.safetensors)"));
  EXPECT_EQ(testing::refusalOf([&] { requireFile(folder / "model.safetensors", "policy p"); }), kTaken);
}

}  // namespace
}  // namespace pusht
