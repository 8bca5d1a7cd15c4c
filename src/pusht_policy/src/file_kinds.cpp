// SPDX-License-Identifier: BSD-3-Clause
#include "file_kinds.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <system_error>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTrace =
    "; in PyTorch, give its network to torch.jit.trace(network.eval(), torch.zeros(1, 10)) and save that";

bool has(std::string_view bytes, std::string_view what) { return bytes.find(what) != std::string_view::npos; }

bool begins(std::string_view bytes, std::string_view what) { return bytes.substr(0, what.size()) == what; }

bool isZip(std::string_view bytes) { return begins(bytes, "PK\x03\x04"); }

/// An archive of torch.save() has its pickle.
bool isSaved(std::string_view bytes) { return isZip(bytes) && has(bytes, "/data.pkl"); }

/// Length of a JSON header in 8 bytes, then the header. Source: https://huggingface.co/docs/safetensors.
bool isSafetensors(std::string_view bytes) {
  constexpr std::size_t kLength = 8;
  constexpr std::size_t kLongestHeader = 3;  // bytes of the length that may be other than 0
  return bytes.size() > kLength && bytes[kLength] == '{' &&
         std::all_of(bytes.begin() + kLongestHeader, bytes.begin() + kLength, [](char byte) { return byte == 0; });
}

/// Version and producer of a ModelProto. Source: onnx.proto, fields 1 and 2.
bool isOnnx(std::string_view bytes) {
  constexpr char kLastVersion = 32;
  return bytes.size() > 2 && bytes[0] == '\x08' && bytes[1] > 0 && bytes[1] < kLastVersion && bytes[2] == '\x12';
}

/// A format by which files are known, what it is, and what to do.
struct Format {
  bool (*is)(std::string_view bytes);
  std::string_view what;
  std::string_view advice;
};

constexpr std::array kFormats = {
    Format{[](std::string_view b) { return isZip(b) && has(b, "stable_baselines3"); }, "a model of Stable-Baselines3",
           "; load it there, and trace its actor: docs/networks.md has an example"},
    Format{[](std::string_view b) {
             return isZip(b) && (has(b, "serialized_exported_program") || has(b, "models/model.json"));
           },
           "an ExportedProgram (torch.export)", kTrace},
    Format{[](std::string_view b) { return isSaved(b) && has(b, "OrderedDict"); },
           "weights without their network (a state_dict)", kTrace},
    Format{isSaved, "a pickled object (torch.save), which needs its Python code", kTrace},
    Format{[](std::string_view b) {
             return begins(b, "\x80\x02") || begins(b, "\x80\x03") || begins(b, "\x80\x04") || begins(b, "\x80\x05");
           },
           "a pickled object, which needs its Python code", kTrace},
    Format{isSafetensors, "weights without their network (safetensors)", kTrace},
    Format{[](std::string_view b) { return begins(b, "\x89HDF"); }, "an HDF5 file, as of Keras", "; export it to ONNX"},
    Format{isOnnx, "an ONNX model, by its first bytes", "; name it NAME.onnx"},
};

}  // namespace

void requireFile(const fs::path& path, const std::string& name) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    return;
  }
  const bool has_weights = fs::exists(path / "model.safetensors", ignored);
  throw InvalidInput(
      name + ": must be a readable file, is a folder" +
      (has_weights ? " with weights without their network (model.safetensors)" + std::string(kTrace) : std::string()));
}

void requireNoOtherFormat(const std::string& bytes, const std::string& name) {
  if (isZip(bytes) && has(bytes, "/constants.pkl")) {
    return;  // TorchScript, whatever its modules are called
  }
  for (const Format& format : kFormats) {
    if (format.is(bytes)) {
      throw InvalidInput(name + ": must be TorchScript, is " + std::string(format.what) + std::string(format.advice));
    }
  }
}

}  // namespace pusht
