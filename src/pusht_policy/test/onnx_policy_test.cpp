// SPDX-License-Identifier: BSD-3-Clause
/// Policies from ONNX files: the bits of their TorchScript, and what is refused.
#include "../src/onnx_policy.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "network_testing.hpp"
#include "onnx_testing.hpp"
#include "pusht_policy/network_policy.hpp"
#include "pusht_policy/policy_choice.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

/// Loading `path` must fail so, with a message of one line that names the file and has `part`.
void expectFileRefusal(const fs::path& path, ExitCode exit_code, const std::string& part) {
  try {
    OnnxPolicy::load(path);
    FAIL() << path << " is accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.exitCode(), exit_code) << error.what();
    EXPECT_THAT(error.what(), HasSubstr("policy " + path.string() + ": "));
    EXPECT_THAT(error.what(), HasSubstr(part));
    EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
  }
}

/// Files that torch exports, with the TorchScript that they are exported from, once for all tests.
const testing::TemporaryFolder& filesFromTorch() {
  static const testing::TemporaryFolder folder;
  static const bool written =
      (testing::runPython(std::string(PUSHT_MAKE_ONNX) + " " + PUSHT_POLICIES_DIR + " " + (folder / "").string()),
       true);
  static_cast<void>(written);
  return folder;
}

TEST(OnnxFromTorch, ActsAsItsTorchScriptToTheLastBit) {
  const std::vector<Observation> observations = testing::manyObservations();
  int files = 0;
  for (const auto& entry : fs::directory_iterator(filesFromTorch().path())) {
    const std::string stem = entry.path().stem().string();
    if (entry.path().extension() != ".onnx" || stem.rfind("described_", 0) == 0) {
      continue;
    }
    ++files;
    const auto onnx = OnnxPolicy::load(entry.path());
    const auto torch = NetworkPolicy::load(filesFromTorch() / (stem.substr(0, stem.find('-')) + ".ts.pt"));
    EXPECT_EQ(torch->info().why_not_on_kernel, "") << stem;
    EXPECT_TRUE(onnx->info().operations == torch->info().operations || stem.rfind("graph_", 0) == 0) << stem;
    for (const std::size_t batch : {1, 7, 1000}) {
      EXPECT_EQ(testing::bits(testing::flatten(testing::act(*onnx, observations, batch))),
                testing::bits(testing::flatten(testing::act(*torch, observations))))
          << stem;
    }
  }
  EXPECT_EQ(files, 34);
}

TEST(OnnxFromTorch, HasHistoryChunksStateAndNoiseAsItsTorchScript) {
  for (const std::string name : {"chunks", "noise", "gru", "lstm"}) {
    const auto onnx = OnnxPolicy::load(filesFromTorch() / ("described_" + name + ".onnx"));
    const auto torch = NetworkPolicy::load(filesFromTorch() / ("described_" + name + ".ts.pt"));
    EXPECT_EQ(torch->info().why_not_on_kernel, "") << name;
    EXPECT_EQ(toJson(onnx->info().description), toJson(torch->info().description));
    const std::vector<Beginning> beginnings = {{1}, {2}, {3}};
    EXPECT_EQ(testing::drive(*onnx, beginnings, 30, 3), testing::drive(*torch, beginnings, 30, 3)) << name;
    EXPECT_EQ(testing::drive(*onnx->clone(), beginnings, 10, 1), testing::drive(*torch, beginnings, 10, 2)) << name;
  }
  const ChosenPolicy chosen = choosePolicy({(filesFromTorch() / "described_noise.onnx").string()}, "none");
  EXPECT_EQ(chosen.identity.at("description").at("execute"), 4);
  EXPECT_EQ(chosen.provenance.at("noise").at("distribution"), "normal");
}

TEST(OnnxFromTorch, IsChosenByItsName) {
  const ChosenPolicy chosen = choosePolicy({(filesFromTorch() / "shipped.onnx").string()}, "none");
  const ChosenPolicy shipped = choosePolicy({}, fs::path(PUSHT_POLICIES_DIR) / "bc_policy.ts.pt");
  EXPECT_EQ(chosen.name, (filesFromTorch() / "shipped.onnx").string());
  EXPECT_EQ(chosen.identity.at("operations"), shipped.identity.at("operations"));
  EXPECT_EQ(chosen.identity.at("sha256"), sha256(readFile(filesFromTorch() / "shipped.onnx", "policy")));
  EXPECT_EQ(chosen.identity.size(), 2U);
  EXPECT_EQ(chosen.provenance.at("runs_on"), "fixed-order kernel");
  EXPECT_EQ(chosen.provenance.at("onnx").at("opset"), 14);
  EXPECT_THAT(chosen.libraries, ::testing::ElementsAre("libpusht_onnx_policy.so"));
  EXPECT_EQ(testing::act(*chosen.make(), testing::observations()),
            testing::act(*shipped.make(), testing::observations()));
}

/// Its provenance is beside it, from the export.
TEST(OnnxFromTorch, IsRefusedIfItIsNotTheOneOfItsProvenance) {
  const testing::TemporaryFolder folder;
  for (const char* end : {"", ".provenance.json"}) {
    fs::copy(filesFromTorch() / (std::string("shipped.onnx") + end), folder / (std::string("policy.onnx") + end));
  }
  EXPECT_TRUE(OnnxPolicy::load(folder / "policy.onnx"));
  std::string bytes = readFile(folder / "policy.onnx", "policy");
  bytes[bytes.size() / 2] ^= 1;
  writeFile(folder / "policy.onnx", bytes);
  expectFileRefusal(folder / "policy.onnx", ExitCode::kBadDependency, "its SHA-256 is");
}

class OnnxFile : public ::testing::Test {
 protected:
  const testing::TemporaryFolder folder_;
  const fs::path path_ = folder_ / "policy.onnx";
};

TEST_F(OnnxFile, IsRefusedIfItIsNotThereOrNoFile) {
  expectFileRefusal(path_, ExitCode::kInvalidInput, "must be a readable file");
  fs::create_directory(path_);
  expectFileRefusal(path_, ExitCode::kInvalidInput, "must be a readable file");
}

/// Nothing is read of it: the file has no blocks on the disk.
TEST_F(OnnxFile, OfThreeGigabytesIsRefused) {
  writeFile(path_, "");
  fs::resize_file(path_, 3'000'000'000);
  expectFileRefusal(path_, ExitCode::kInvalidInput, "must have at most 2147483647 bytes");
}

TEST_F(OnnxFile, WhoseActionsAreNotFiniteIsRefused) {
  onnx::ModelProto model =
      testing::onnxModel(testing::op("Gemm", {"x", "big"}, "a") + testing::op("Gemm", {"a", "big2"}, "y"));
  testing::addTensor(*model.mutable_graph(), "big", {10, 2}, std::vector<float>(20, 1e30F));
  testing::addTensor(*model.mutable_graph(), "big2", {2, 2}, std::vector<float>(4, 1e30F));
  writeFile(path_, model.SerializeAsString());
  expectFileRefusal(path_, ExitCode::kBadDependency,
                    "its actions must be finite, but action 1 of 1 is -inf for probe 0");
}

/// Model whose first weights are in weights.bin, with this location.
onnx::ModelProto withDataOutside(const std::string& location, const std::string& offset) {
  onnx::ModelProto model = testing::onnxModel(testing::op("Gemm", {"x", "w", "b"}, "y"));
  onnx::TensorProto& tensor = *model.mutable_graph()->mutable_initializer(0);
  tensor.clear_raw_data();
  tensor.set_data_location(onnx::TensorProto::EXTERNAL);
  for (const auto& [key, value] : {std::pair("location", location), std::pair("offset", offset)}) {
    onnx::StringStringEntryProto& entry = *tensor.add_external_data();
    entry.set_key(key);
    entry.set_value(value);
  }
  return model;
}

TEST_F(OnnxFile, MayHaveItsValuesInAFileBesideIt) {
  const onnx::ModelProto whole = testing::onnxModel(testing::op("Gemm", {"x", "w", "b"}, "y"));
  writeFile(path_, whole.SerializeAsString());
  const std::vector<Action> expected = testing::act(*OnnxPolicy::load(path_), testing::observations());
  const std::string data = "skipped." + whole.graph().initializer(0).raw_data();
  writeFile(folder_ / "weights.bin", data);
  writeFile(path_, withDataOutside("weights.bin", "8").SerializeAsString());
  const auto policy = OnnxPolicy::load(path_);
  EXPECT_EQ(testing::act(*policy, testing::observations()), expected);
  const ChosenPolicy chosen = choosePolicy({path_.string()}, "none");
  EXPECT_EQ(chosen.identity.at("data_files").at("weights.bin"), sha256(data)) << "the network is known by both files";
  writeFile(path_, withDataOutside("weights.bin", "100").SerializeAsString());
  expectFileRefusal(path_, ExitCode::kInvalidInput, "must be in the 88 bytes of 'weights.bin', but begins at 100");
  writeFile(path_, withDataOutside("weights.bin", "9").SerializeAsString());
  expectFileRefusal(path_, ExitCode::kInvalidInput,
                    "tensor 'w': must hold the values of its shape [10, 2], but holds 79");
  writeFile(path_, withDataOutside("weights.bin", "-8").SerializeAsString());
  expectFileRefusal(path_, ExitCode::kInvalidInput, "offset of its external data must be a number of bytes, not '-8'");
  for (const std::string outside : {"../weights.bin", "/etc/hostname", "..", "folder/weights.bin", ""}) {
    writeFile(path_, withDataOutside(outside, "0").SerializeAsString());
    expectFileRefusal(path_, ExitCode::kInvalidInput,
                      "in the file itself or in one beside it (external data), not in '");
  }
  writeFile(path_, withDataOutside("none.bin", "0").SerializeAsString());
  expectFileRefusal(path_, ExitCode::kInvalidInput, "must be a readable file");
}

/// The description is the metadata policy.json, as TorchScript has an extra file of that name.
TEST_F(OnnxFile, MustDoWhatItsDescriptionSays) {
  onnx::ModelProto model = testing::onnxModel(testing::op("Gemm", {"x", "w", "b"}, "y"));
  onnx::StringStringEntryProto& entry = *model.add_metadata_props();
  entry.set_key("policy.json");
  entry.set_value(R"({"format": 1, "observations": 1, "actions": 1, "state": {"shape": [3]}})");
  writeFile(path_, model.SerializeAsString());
  expectFileRefusal(path_, ExitCode::kBadDependency, "must have 2 inputs, as its description says");
  entry.set_value(R"({"format": 1, "observations": 2, "actions": 1})");
  writeFile(path_, model.SerializeAsString());
  expectFileRefusal(path_, ExitCode::kBadDependency, "input 'x': must be FLOAT [n, 2, 10] or [1, 2, 10], but is");
  entry.set_value("{");
  writeFile(path_, model.SerializeAsString());
  expectFileRefusal(path_, ExitCode::kInvalidInput, "policy.json: must be JSON");
}

/// Operators of ONNX that torch's exporter does not write, against plain arithmetic.
TEST_F(OnnxFile, HasTheCellsOfOnnx) {
  constexpr int kUnits = 2;
  NumpyGenerator generator(20003);
  const auto values = [&](int count) { return testing::randomValues(generator, count, 0.7); };
  const std::vector<float> w = values(3 * kUnits * 10);
  const std::vector<float> r = values(3 * kUnits * kUnits);
  const std::vector<float> b = values(6 * kUnits);
  const std::vector<float> h0 = values(kUnits);
  onnx::ModelProto model =
      testing::onnxModel(testing::op("Unsqueeze", {"x", "zero"}, "sequence") +
                         testing::op("GRU", {"sequence", "gru_w", "gru_r", "gru_b", "", "h0"}, "all",
                                     "output: 'last' " + testing::integerAttribute("hidden_size", "2") +
                                         testing::integerAttribute("linear_before_reset", "1")) +
                         testing::op("Squeeze", {"last", "zero"}, "y"));
  onnx::GraphProto& graph = *model.mutable_graph();
  testing::addTensor(graph, "gru_w", {1, 3 * kUnits, 10}, w);
  testing::addTensor(graph, "gru_r", {1, 3 * kUnits, kUnits}, r);
  testing::addTensor(graph, "gru_b", {1, 6 * kUnits}, b);
  testing::addTensor(graph, "h0", {1, 1, kUnits}, h0);
  onnx::TensorProto& zero = *graph.add_initializer();
  zero.set_name("zero");
  zero.set_data_type(onnx::TensorProto::INT64);
  zero.add_dims(1);
  zero.add_int64_data(0);
  writeFile(path_, model.SerializeAsString());
  const auto policy = OnnxPolicy::load(path_);
  const auto sigmoid = [](double x) { return 1.0 / (1.0 + std::exp(-x)); };
  for (const Observation& x : testing::observations()) {
    const auto of_input = [&](int row) {
      double sum = b[row];
      for (int k = 0; k < 10; ++k) {
        sum += static_cast<double>(w[row * 10 + k]) * x[k];
      }
      return sum;
    };
    const auto of_state = [&](int row) {
      double sum = b[3 * kUnits + row];
      for (int k = 0; k < kUnits; ++k) {
        sum += static_cast<double>(r[row * kUnits + k]) * h0[k];
      }
      return sum;
    };
    const Action action = testing::act(*policy, {x}).front();
    for (int unit = 0; unit < kUnits; ++unit) {  // gates in ONNX's order: update, reset, hidden
      const double update = sigmoid(of_input(unit) + of_state(unit));
      const double reset = sigmoid(of_input(kUnits + unit) + of_state(kUnits + unit));
      const double fresh = std::tanh(of_input(2 * kUnits + unit) + reset * of_state(2 * kUnits + unit));
      EXPECT_NEAR(action[unit], (1.0 - update) * fresh + update * h0[unit], 1e-6);
    }
  }
}

/// A small model, so that a flipped byte is seldom a weight.
class DamagedOnnx : public OnnxFile {
 protected:
  std::size_t below(std::size_t bound) {
    return static_cast<std::size_t>(generator_.uniform(0, static_cast<double>(bound)));
  }

  /// Whether the bytes are refused, in one line; if not, the policy must act.
  bool isRefused(const std::string& bytes) {
    writeCacheFile(path_, bytes);  // no wait for the disk
    try {
      const auto policy = OnnxPolicy::load(path_);
      testing::act(*policy, testing::observations());
      return false;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
      EXPECT_THAT(error.what(), HasSubstr(path_.string()));
      EXPECT_TRUE(error.exitCode() == ExitCode::kInvalidInput || error.exitCode() == ExitCode::kBadDependency)
          << error.what();
      return true;
    }
  }

  /// How many of the mutations are refused.
  template <class Mutate>
  int refusedOf(int mutations, const Mutate& mutate) {
    int count = 0;
    for (int i = 0; i < mutations; ++i) {
      count += isRefused(mutate()) ? 1 : 0;
    }
    std::cout << count << " of " << mutations << " refused" << std::endl;
    return count;
  }

  const std::string whole_ =
      testing::onnxModel(testing::op("Constant", {}, "c", testing::tensorAttribute("data_type: 1 float_data: 2.5")) +
                         testing::op("Mul", {"x", "c"}, "a") +
                         testing::op("Gemm", {"a", "w_t", "b"}, "h", testing::integerAttribute("transB", "1")) +
                         testing::op("Clip", {"h", "number", "one"}, "y"))
          .SerializeAsString();
  NumpyGenerator generator_{20002};
};

TEST_F(DamagedOnnx, WithOtherBytesNeverCrashes) {
  EXPECT_FALSE(isRefused(whole_));
  const std::size_t structure = whole_.find("w0");  // names, types and shapes come before the large tensors
  const int refused = refusedOf(3000, [&] {
    std::string bytes = whole_;
    for (std::size_t flips = 1 + below(3); flips > 0; --flips) {
      char& byte = bytes[below(structure)];
      byte = static_cast<char>(byte ^ static_cast<char>(1 + below(255)));
    }
    return bytes;
  });
  EXPECT_GT(refused, 1500);
}

TEST_F(DamagedOnnx, CutOffIsRefused) {
  for (std::size_t size = 0; size < whole_.size(); ++size) {
    EXPECT_TRUE(isRefused(whole_.substr(0, size))) << size << " bytes";
  }
}

TEST_F(DamagedOnnx, WithoutOrWithMoreBytesNeverCrashes) {
  EXPECT_GT(refusedOf(1000,
                      [&] {
                        std::string bytes = whole_;
                        const std::size_t place = below(bytes.size());
                        return below(2) == 0 ? bytes.erase(place, 1 + below(40))
                                             : bytes.insert(place, std::string(1 + below(40), '\x0a'));
                      }),
            900);
}

TEST_F(DamagedOnnx, RandomBytesAreRefused) {
  EXPECT_EQ(refusedOf(1000,
                      [&] {
                        std::string bytes(1 + below(200), '\0');
                        for (char& byte : bytes) {
                          byte = static_cast<char>(below(256));
                        }
                        return bytes;
                      }),
            1000);
}

}  // namespace
}  // namespace pusht
