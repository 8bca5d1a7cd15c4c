// SPDX-License-Identifier: BSD-3-Clause
#include <caffe2/serialize/inline_container.h>
#include <torch/csrc/jit/api/compilation_unit.h>
#include <torch/csrc/jit/frontend/script_type_parser.h>
#include <torch/csrc/jit/serialization/unpickler.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <sstream>
#include <utility>

#include "pusht_task/error.hpp"
#include "torch_network.hpp"

namespace pusht {
namespace {

/// Whether every element of `tensor` lies in its storage: libtorch believes what the pickle says.
bool liesInItsStorage(const at::Tensor& tensor) {
  if (tensor.numel() == 0) {
    return true;
  }
  const auto room = static_cast<std::int64_t>(tensor.storage().nbytes() / tensor.dtype().itemsize());
  std::int64_t last = tensor.storage_offset();
  bool sound = last >= 0 && last < room;
  for (std::int64_t axis = 0; sound && axis < tensor.dim(); ++axis) {
    const std::int64_t steps = tensor.size(axis) - 1;
    const std::int64_t stride = tensor.stride(axis);
    sound = steps >= 0 && stride >= 0 && (steps == 0 || stride <= (room - 1 - last) / steps);
    last += sound ? steps * stride : 0;
  }
  return sound;
}

/// Types in a pickle, all of whose classes are empty here.
class PickledTypes : public torch::jit::Resolver {
 public:
  c10::StrongTypePtr typeOf(const c10::QualifiedName& name) {
    return c10::StrongTypePtr(unit_, isClass(name.qualifiedName()) ? classOf(name) : parse(name.qualifiedName()));
  }

  c10::TypePtr resolveType(const std::string& name, const torch::jit::SourceRange& /*place*/) override {
    return isClass(name) ? classOf(name) : nullptr;
  }

 private:
  static bool isClass(const std::string& name) { return name.rfind("__torch__.", 0) == 0; }

  c10::TypePtr classOf(const c10::QualifiedName& name) const { return c10::ClassType::create(name, unit_, true); }

  /// Type of a container, such as the lists in a recurrent layer: "List[str]".
  c10::TypePtr parse(const std::string& text) {
    const torch::jit::ResolverPtr resolver(std::shared_ptr<void>(), this);  // the parser does not outlive this call
    return torch::jit::ScriptTypeParser(resolver).parseType(text);
  }

  std::shared_ptr<torch::jit::CompilationUnit> unit_ = std::make_shared<torch::jit::CompilationUnit>();
};

/// Reads the pickles of a checkpoint as libtorch does, but for its classes, to see what they ask of the records.
class PickleCheck {
 public:
  PickleCheck(const Records& records, std::string root, std::string name)
      : records_(records), root_(std::move(root)), name_(std::move(name)) {}

  /// `pickle` is "data" or "constants".
  void check(const std::string& pickle, std::uint64_t version) {
    const std::string& text = record(pickle + ".pkl");
    std::size_t position = 0;
    const auto read = [&](char* target, std::size_t wanted) {
      const std::size_t count = std::min(wanted, text.size() - position);
      std::memcpy(target, text.data() + position, count);
      position += count;
      return count;
    };
    const auto resolve = [&](const c10::QualifiedName& type) { return types_.typeOf(type); };
    const auto load = [&](const c10::StrongTypePtr& type, const torch::jit::IValue& state) {
      requireWholeTensors(state);
      return c10::ivalue::Object::create(type, 0);
    };
    const auto read_record = [&](const std::string& key) {
      const std::string path = pickle + "/" + key;
      const std::string& content = record(path);
      record_at_[content.data()] = path;
      return at::DataPtr(const_cast<char*>(content.data()), at::kCPU);  // nothing writes to it
    };
    torch::jit::Unpickler unpickler(read, resolve, load, read_record, at::Device(at::kCPU));
    unpickler.set_version(version);
    requireWholeTensors(unpickler.parse_ivalue());
  }

 private:
  const std::string& record(const std::string& path) const {
    const auto found = records_.find(root_ + path);
    if (found == records_.end()) {
      throw InvalidInput(name_ + ": must be TorchScript: has no record " + root_ + path);
    }
    return found->second;
  }

  void requireWholeTensors(const torch::jit::IValue& value) const {
    value.visit([&](const torch::jit::IValue& part) {
      if (part.isTensor() && part.toTensor().has_storage()) {
        requireWhole(part.toTensor());
      }
      return false;
    });
  }

  void requireWhole(const at::Tensor& tensor) const {
    const std::size_t wanted = tensor.storage().nbytes();
    const auto found = record_at_.find(tensor.storage().data());
    const std::string path = found == record_at_.end() ? "" : found->second;
    const std::size_t size = path.empty() ? 0 : record(path).size();
    const std::string where = name_ + ": record " + root_ + path;
    if (size != wanted) {
      throw InvalidInput(where + ": must have the " + std::to_string(wanted) + " bytes of its tensor, but has " +
                         std::to_string(size));
    }
    if (!liesInItsStorage(tensor)) {
      throw InvalidInput(where + ": must hold all elements of its tensor, but has " + std::to_string(size) + " bytes");
    }
  }

  const Records& records_;
  std::string root_;
  std::string name_;
  PickledTypes types_;
  std::map<const void*, std::string> record_at_;
};

void requireSameBytes(const std::string& found, const std::string& wanted, const std::string& where) {
  if (found != wanted) {
    throw InvalidInput(where + ": libtorch must find the archive's bytes, but finds others");
  }
}

/// libtorch has a reader of archives of its own: it must find the bytes that were verified.
void requireSameRecords(caffe2::serialize::PyTorchStreamReader& reader, const Records& records, const std::string& root,
                        const std::string& name) {
  if (reader.getAllRecords().size() != records.size()) {
    throw InvalidInput(name + ": must have " + std::to_string(records.size()) + " records, but libtorch finds " +
                       std::to_string(reader.getAllRecords().size()));
  }
  const std::string in_archive = name + ": record ";
  for (const auto& [record, content] : records) {
    const auto [bytes, size] = reader.getRecord(record.substr(std::min(root.size(), record.size())));
    requireSameBytes({static_cast<const char*>(bytes.get()), size}, content, in_archive + record);
  }
}

}  // namespace

void requireWholeTensors(const std::string& bytes, const Records& records, const std::string& name) {
  try {
    std::istringstream stream(bytes);
    caffe2::serialize::PyTorchStreamReader reader(&stream);
    const std::string first = records.empty() ? "" : records.begin()->first;
    const std::string root = first.substr(0, first.find('/') + 1);
    requireSameRecords(reader, records, root, name);
    PickleCheck pickles(records, root, name);
    pickles.check("constants", reader.version());
    pickles.check("data", reader.version());
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw InvalidInput(name + ": must be TorchScript: " + firstLine(error));
  }
}

}  // namespace pusht
