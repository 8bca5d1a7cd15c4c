// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/traces.hpp"

#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>

#include "pusht_task/error.hpp"

namespace sim2sim {
namespace {

constexpr std::size_t kModeLength = 16;  // of the longest, reference_closed
constexpr std::size_t kRecordSize = 2 * sizeof(std::int32_t) + kModeLength + 5 * sizeof(double) + sizeof(pusht::Action);
constexpr std::size_t kHeaderSize = 384;  // a multiple of 64, as the format wants it

template <class Number>
void append(std::string& bytes, Number number) {
  static_assert(std::is_arithmetic_v<Number>);
  bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));  // x86 and ARM are little-endian
}

/// Header of the file. Its length does not depend on `records`, so that it can be written again with the final number.
std::string header(std::size_t records) {
  std::string fields = "('episode', '<i4'), ('mode', 'S" + std::to_string(kModeLength) + "'), ('step', '<i4')";
  for (const char* name : {"pusher_x", "pusher_y", "tee_x", "tee_y", "tee_yaw"}) {
    fields.append(", ('").append(name).append("', '<f8')");
  }
  for (const char* name : {"action_x", "action_y"}) {
    fields.append(", ('").append(name).append("', '<f4')");
  }
  constexpr std::size_t kPreamble = 10;  // magic, version, length of what follows
  std::string text =
      "{'descr': [" + fields + "], 'fortran_order': False, 'shape': (" + std::to_string(records) + ",), }";
  if (kPreamble + text.size() + 1 > kHeaderSize) {
    throw pusht::InternalError("the header of traces.npy does not fit");
  }
  text.resize(kHeaderSize - kPreamble - 1, ' ');
  std::string bytes = "\x93NUMPY";
  append(bytes, std::uint8_t{1});
  append(bytes, std::uint8_t{0});
  append(bytes, static_cast<std::uint16_t>(text.size() + 1));
  return bytes + text + "\n";
}

std::string recordsOf(const Episode& episode) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  std::string bytes;
  for (const Mode mode : kModes) {
    if (!episode.protocol().isFlown(mode)) {
      continue;
    }
    const pusht::Trace& trace = episode.rollout(mode).trace();
    std::string name = modeName(mode);
    name.resize(kModeLength, '\0');
    for (std::size_t step = 0; step < trace.states.size(); ++step) {
      const pusht::WorldState& state = trace.states[step];
      append(bytes, static_cast<std::int32_t>(episode.index()));
      bytes += name;
      append(bytes, static_cast<std::int32_t>(step));
      for (const double number : {state.pusher_position.x(), state.pusher_position.y(), state.tee_position.x(),
                                  state.tee_position.y(), state.tee_yaw}) {
        append(bytes, number);
      }
      const pusht::Action action = step < trace.actions.size() ? trace.actions[step] : pusht::Action{kNone, kNone};
      append(bytes, action[0]);
      append(bytes, action[1]);
    }
  }
  return bytes;
}

}  // namespace

TraceFile::TraceFile(const std::filesystem::path& path) : file_(path) { file_.write(header(0), false); }

void TraceFile::add(const Episode& episode) {
  const std::string records = recordsOf(episode);
  file_.write(records, false);
  records_ += records.size() / kRecordSize;
}

void TraceFile::finish() {
  file_.writeAt(0, header(records_));
  file_.moveIntoPlace();
}

}  // namespace sim2sim
