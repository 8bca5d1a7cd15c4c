// SPDX-License-Identifier: BSD-3-Clause
#include "onnx_constants.hpp"

#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"

namespace pusht {
namespace {

using onnx::TensorProto;

/// Number of values of a shape. Throws InvalidInput, beginning with `where`, for a negative dimension.
std::uint64_t valuesOf(const std::vector<std::int64_t>& shape, const std::string& where) {
  constexpr std::uint64_t kMany = std::numeric_limits<std::uint64_t>::max();  // more than any file holds
  std::uint64_t count = 1;
  for (const std::int64_t dimension : shape) {
    if (dimension < 0) {
      throw InvalidInput(where + ": its dimensions must not be negative, but are " + textOf(shape));
    }
    const auto factor = static_cast<std::uint64_t>(dimension);
    count = factor != 0 && count > kMany / factor ? kMany : count * factor;
  }
  return count;
}

/// Values of a tensor, which lie in its raw bytes (of Element each) or else in `field`. Nothing is allocated before
/// the tensor is known to hold them.
template <class Value, class Element, class Field>
std::vector<Value> valuesIn(const TensorProto& tensor, const Field& field, const std::vector<std::int64_t>& shape,
                            const std::string& where) {
  const std::string& raw = tensor.raw_data();
  const std::uint64_t count = valuesOf(shape, where);
  const std::uint64_t held = tensor.has_raw_data() ? raw.size() / sizeof(Element) : field.size();
  const bool is_whole = !tensor.has_raw_data() || (raw.size() % sizeof(Element) == 0 && field.empty());
  if (held != count || !is_whole) {
    throw InvalidInput(where + ": must hold the values of its shape " + textOf(shape) + ", but holds " +
                       (tensor.has_raw_data() ? std::to_string(raw.size()) + " bytes" : std::to_string(held)));
  }
  std::vector<Value> values(count);
  if (!tensor.has_raw_data()) {
    std::copy(field.begin(), field.end(), values.begin());
    return values;
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    Element element{};
    std::memcpy(&element, raw.data() + i * sizeof(Element), sizeof(Element));  // little-endian, as in the format
    values[i] = static_cast<Value>(element);
  }
  return values;
}

template <class Values>
void requireFiniteValues(const Values& values, const std::string& where) {
  if (!std::all_of(values.begin(), values.end(), [](auto value) { return std::isfinite(value); })) {
    throw BadDependency(where + ": its values must be finite");
  }
}

OnnxConstant floatConstant(std::vector<std::int64_t> shape, std::vector<float> values, const std::string& where) {
  requireFiniteValues(values, where);
  return {TensorProto::FLOAT, {std::move(shape), std::move(values)}, {}};
}

}  // namespace

std::string quoted(const std::string& name) {
  constexpr std::size_t kLongest = 80;
  std::string text = name.size() > kLongest ? name.substr(0, kLongest) + "..." : name;
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return "'" + text + "'";
}

std::string textOf(const std::vector<std::int64_t>& shape) {
  std::vector<std::string> dimensions(shape.size());
  std::transform(shape.begin(), shape.end(), dimensions.begin(), [](std::int64_t d) { return std::to_string(d); });
  return "[" + (dimensions.empty() ? "" : joined(dimensions)) + "]";
}

std::string OnnxDataFiles::bytesOf(const TensorProto& tensor, const std::string& where) {
  std::map<std::string, std::string> entries;
  for (const onnx::StringStringEntryProto& entry : tensor.external_data()) {
    entries[entry.key()] = entry.value();
  }
  const std::string& name = entries["location"];
  if (folder_.empty() || name.empty() || name == "." || name == ".." || name.find('/') != std::string::npos) {
    throw InvalidInput(where + ": its values must be in the file itself or in one beside it (external data), not in " +
                       quoted(name));
  }
  if (contents_.count(name) == 0) {
    contents_[name] = readFile(folder_ / name, "external data of the policy");
  }
  const std::string& content = contents_[name];
  const auto number = [&](const char* key, std::uint64_t otherwise) {
    const std::string& text = entries[key];
    const bool is_number = text.size() < 19 && text.find_first_not_of("0123456789") == std::string::npos;
    if (!is_number) {
      throw InvalidInput(where + ": " + key + " of its external data must be a number of bytes, not " + quoted(text));
    }
    return text.empty() ? otherwise : std::stoull(text);
  };
  const std::uint64_t offset = number("offset", 0);
  const std::uint64_t length = number("length", content.size() - std::min<std::uint64_t>(offset, content.size()));
  if (offset > content.size() || length > content.size() - offset) {
    throw InvalidInput(where + ": must be in the " + std::to_string(content.size()) + " bytes of " + quoted(name) +
                       ", but begins at " + std::to_string(offset) + " and has " + std::to_string(length));
  }
  return content.substr(offset, length);
}

std::map<std::string, std::string> OnnxDataFiles::hashes() const {
  std::map<std::string, std::string> hashes;
  for (const auto& [name, content] : contents_) {
    hashes[name] = sha256(content);
  }
  return hashes;
}

OnnxConstant readTensor(const TensorProto& tensor, const std::string& name, OnnxDataFiles& files) {
  constexpr int kMostDimensions = 16;
  const std::string where = "tensor " + quoted(name);
  if (tensor.data_location() != TensorProto::DEFAULT || tensor.external_data_size() > 0) {
    TensorProto whole;
    *whole.mutable_dims() = tensor.dims();
    whole.set_data_type(tensor.data_type());
    whole.set_raw_data(files.bytesOf(tensor, where));
    return readTensor(whole, name, files);
  }
  if (tensor.has_segment() || tensor.dims_size() > kMostDimensions) {
    throw InvalidInput(where + ": must be in one piece, with at most " + std::to_string(kMostDimensions) +
                       " dimensions");
  }
  const std::vector<std::int64_t> shape(tensor.dims().begin(), tensor.dims().end());
  OnnxConstant constant{tensor.data_type(), {shape, {}}, {}};
  switch (tensor.data_type()) {
    case TensorProto::FLOAT:
      constant.tensor.values = valuesIn<float, float>(tensor, tensor.float_data(), shape, where);
      break;
    case TensorProto::DOUBLE:
      constant.numbers = valuesIn<double, double>(tensor, tensor.double_data(), shape, where);
      break;
    case TensorProto::INT64:
      constant.numbers = valuesIn<double, std::int64_t>(tensor, tensor.int64_data(), shape, where);
      break;
    case TensorProto::INT32:
      constant.numbers = valuesIn<double, std::int32_t>(tensor, tensor.int32_data(), shape, where);
      break;
    case TensorProto::BOOL:
      constant.numbers = valuesIn<double, std::uint8_t>(tensor, tensor.int32_data(), shape, where);
      break;
    default:
      valuesOf(shape, where);
  }
  requireFiniteValues(constant.tensor.values, where);
  requireFiniteValues(constant.numbers, where);
  return constant;
}

OnnxConstant readConstantNode(const onnx::NodeProto& node, OnnxDataFiles& files) {
  const std::string name = node.output_size() > 0 ? node.output(0) : "";
  const std::string where = "tensor " + quoted(name);
  if (node.attribute_size() != 1) {
    throw UnfitForKernel("must have one value");
  }
  const onnx::AttributeProto& value = node.attribute(0);
  if (value.name() == "value" && value.has_t()) {
    return readTensor(value.t(), name, files);
  }
  if (value.name() == "value_float") {
    return floatConstant({}, {value.f()}, where);
  }
  if (value.name() == "value_floats") {
    return floatConstant({value.floats_size()}, {value.floats().begin(), value.floats().end()}, where);
  }
  if (value.name() == "value_int") {
    return {TensorProto::INT64, {}, {static_cast<double>(value.i())}};
  }
  if (value.name() == "value_ints") {
    return {TensorProto::INT64, {{value.ints_size()}, {}}, {value.ints().begin(), value.ints().end()}};
  }
  throw UnfitForKernel("its value must be a tensor or numbers, not " + quoted(value.name()));
}

OnnxConstant castToFloat(const OnnxConstant& constant) {
  if (constant.type == TensorProto::FLOAT) {
    return constant;
  }
  std::vector<float> values(constant.numbers.size());
  std::transform(constant.numbers.begin(), constant.numbers.end(), values.begin(),
                 [](double number) { return static_cast<float>(number); });
  if (values.size() != valuesOf(constant.tensor.shape, "constant")) {
    throw UnfitForKernel("its operand must be of a type that the kernel knows");
  }
  return floatConstant(constant.tensor.shape, std::move(values), "constant");
}

}  // namespace pusht
