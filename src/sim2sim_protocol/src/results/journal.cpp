// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/journal.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/json_text.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/results/difference.hpp"
#include "sim2sim_protocol/results/episodes_csv.hpp"
#include "sim2sim_protocol/results/result_files.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kDigits = 16;  // of a line's SHA-256

std::string lineOf(const json& content) {
  const std::string text = content.dump();
  return pusht::sha256(text).substr(0, kDigits) + " " + text + "\n";
}

/// The content of a line; null if it is not as it was written.
json contentOf(std::string_view line) {
  if (line.size() <= kDigits || line[kDigits] != ' ') {
    return {};
  }
  const std::string text(line.substr(kDigits + 1));
  return pusht::sha256(text).compare(0, kDigits, line.substr(0, kDigits)) == 0 ? pusht::parseJson(text) : json();
}

}  // namespace

Journal::Journal(fs::path path, const Protocol& protocol, const json& identity)
    : path_(std::move(path)), csv_head_(episodesCsv(protocol, {})), protocol_(protocol) {
  std::error_code ignored;
  const bool is_there = fs::symlink_status(path_, ignored).type() != fs::file_type::not_found;
  const bool is_empty = !is_there || read(protocol, identity);
  constexpr mode_t kMode = 0644;
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, kMode);
  if (descriptor_ < 0) {
    throw pusht::RuntimeFault("cannot write " + path_.string() + ": " + std::strerror(errno));
  }
  if (is_empty) {
    append(lineOf({{"format", kJournalFormat}, {"run", identity}}));
  }
}

Journal::~Journal() {
  if (descriptor_ >= 0) {
    ::close(descriptor_);
  }
}

bool Journal::read(const Protocol& protocol, const json& identity) {
  const auto refuse = [this](std::size_t line, const std::string& why) {
    throw pusht::BadDependency("journal " + path_.string() + ": line " + std::to_string(line) + " " + why +
                               "; begin again with --overwrite");
  };
  const std::string text = pusht::readFile(path_, "journal", std::numeric_limits<std::size_t>::max());
  std::size_t begin = 0;
  std::size_t number = 0;
  std::set<int> seen;
  for (std::size_t end = text.find('\n'); end != std::string::npos; begin = end + 1, end = text.find('\n', begin)) {
    const json content = contentOf(std::string_view(text).substr(begin, end - begin));
    if (++number == 1) {
      if (!content.is_object() || content.value("format", json()) != kJournalFormat) {
        refuse(number, "must say the format " + std::to_string(kJournalFormat) + " and the run");
      }
      const std::string difference = firstDifference(content.value("run", json()), identity, ", must be ");
      if (!difference.empty()) {
        throw pusht::InvalidInput("journal " + path_.string() + ": is of another run (" + difference +
                                  "); name another folder, or replace the run with --overwrite");
      }
      continue;
    }
    FinishedEpisode episode;
    try {
      std::vector<EpisodeResult> results =
          episodesFromCsv(protocol, csv_head_ + content.at("episode").get<std::string>());
      episode.result = std::move(results.at(0));
      episode.bins = binsFrom(content.at("bins"));
      for (const Mode mode : {kReferenceClosed, kEngineClosed}) {
        episode.result.rollouts[mode].limited_commands = content.at("limited").at(mode).get<int>();
      }
    } catch (const std::exception&) {
      refuse(number, "is damaged");
    }
    const int index = episode.result.index;
    if (index < protocol.first_episode || index > protocol.lastEpisode() || !seen.insert(index).second) {
      refuse(number, "has episode " + std::to_string(index) + ", which must not be there");
    }
    kept_.push_back(std::move(episode));
  }
  if (begin < text.size() && ::truncate(path_.c_str(), static_cast<off_t>(begin)) != 0) {
    throw pusht::RuntimeFault("cannot write " + path_.string() + ": " + std::strerror(errno));
  }
  return number == 0;
}

std::set<int> Journal::keptIndices() const {
  std::set<int> indices;
  for (const FinishedEpisode& episode : kept_) {
    indices.insert(episode.result.index);
  }
  return indices;
}

void Journal::add(const FinishedEpisode& episode) {
  append(lineOf({{"episode", episodesCsv(protocol_, {episode.result}).substr(csv_head_.size())},
                 {"bins", toJson(episode.bins)},
                 {"limited",
                  {episode.result.rollouts[kReferenceClosed].limited_commands.value_or(0),
                   episode.result.rollouts[kEngineClosed].limited_commands.value_or(0)}}}));
}

void Journal::append(const std::string& line) {
  for (std::size_t done = 0; done < line.size();) {
    const ssize_t count = ::write(descriptor_, line.data() + done, line.size() - done);
    if (count < 0 && errno != EINTR) {
      throw pusht::RuntimeFault("cannot write " + path_.string() + ": " + std::strerror(errno));
    }
    done += count > 0 ? static_cast<std::size_t>(count) : 0;
  }
}

void Journal::remove() {
  std::error_code error;
  fs::remove(path_, error);
  if (error) {
    throw pusht::RuntimeFault("cannot remove " + path_.string() + ": " + error.message());
  }
}

}  // namespace sim2sim
