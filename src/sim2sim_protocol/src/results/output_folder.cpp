// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/output_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <system_error>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/json_text.hpp"
#include "sim2sim_protocol/reference_cache.hpp"
#include "sim2sim_protocol/results/result_files.hpp"

namespace sim2sim {

namespace fs = std::filesystem;

namespace {

/// Files that commands write, by their path in the folder: a regular expression for each part.
struct Pattern {
  std::string key;            // of the ResultFile
  std::optional<Results> of;  // empty: of both
  std::vector<std::regex> parts;
};

/// `text` as a regular expression.
std::string literally(const std::string& text) { return std::regex_replace(text, std::regex("\\."), "\\."); }

/// Patterns of a file of the table.
std::vector<Pattern> patternsOf(const ResultFile& file) {
  static const std::string part = "(\\.part)?";
  const std::string folders = std::string(" ") + file.in + " ";
  const auto is_in = [&](const char* folder) { return folders.find(" " + std::string(folder) + " ") != folders.npos; };
  const std::string name = literally(file.name);
  std::vector<Pattern> patterns;
  if (is_in("run") || is_in("sweep")) {
    const bool both = is_in("run") && is_in("sweep");
    patterns.push_back({file.key,
                        both ? std::nullopt : std::optional(is_in("run") ? Results::kRun : Results::kSweep),
                        {std::regex(name + (file.streamed ? part : ""))}});
  }
  if (is_in("row")) {
    patterns.push_back({file.key,
                        Results::kSweep,
                        {std::regex(rowsFolder("").string()), std::regex("[0-9]{3,}"), std::regex(name + part)}});
  }
  if (is_in("reference")) {
    patterns.push_back({file.key,
                        Results::kSweep,
                        {std::regex(referenceFolder("").string()), std::regex(ReferenceCache::folderPattern()),
                         std::regex(ReferenceCache::filePattern() + part)}});
  }
  return patterns;
}

/// Patterns of all files. Those of files in the folder itself come first, because messages name what is found first.
const std::vector<Pattern>& resultPatterns() {
  static const std::vector<Pattern> all = [] {
    std::vector<Pattern> patterns;
    for (const ResultFile& file : kResultFiles) {
      for (Pattern& pattern : patternsOf(file)) {
        patterns.push_back(std::move(pattern));
      }
    }
    std::stable_sort(patterns.begin(), patterns.end(),
                     [](const Pattern& a, const Pattern& b) { return a.parts.size() < b.parts.size(); });
    return patterns;
  }();
  return all;
}

/// Adds every path in `folder` that matches `file`. Links in the path are not followed.
void find(const fs::path& folder, const Pattern& file, std::size_t part, std::vector<fs::path>& found) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (!std::regex_match(entry.path().filename().string(), file.parts[part])) {
      continue;
    }
    if (part + 1 == file.parts.size()) {
      found.push_back(entry.path());
    } else if (entry.symlink_status(ignored).type() == fs::file_type::directory) {
      find(entry.path(), file, part + 1, found);
    }
  }
}

std::vector<fs::path> find(const fs::path& folder, const Pattern& file) {
  std::vector<fs::path> found;
  if (!folder.empty()) {
    find(folder, file, 0, found);
  }
  return found;
}

/// First entry of `folder` that is no folder, but has the name of a folder of `file`; empty if there is none. Files
/// written below a link would land elsewhere.
fs::path findInPlaceOfFolder(const fs::path& folder, const Pattern& file, std::size_t part = 0) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (part + 1 == file.parts.size() || !std::regex_match(entry.path().filename().string(), file.parts[part])) {
      continue;
    }
    const bool is_folder = entry.symlink_status(ignored).type() == fs::file_type::directory;
    fs::path found = is_folder ? findInPlaceOfFolder(entry.path(), file, part + 1) : entry.path();
    if (!found.empty()) {
      return found;
    }
  }
  return {};
}

/// Whether a status is that of a run without a finished episode: it was refused, or killed early. A status of another
/// format may mean anything, so it is not.
bool tellsOfNoRun(const fs::path& status) {
  std::error_code ignored;
  if (!fs::is_regular_file(fs::symlink_status(status, ignored))) {
    return false;
  }
  const auto content = pusht::parseJson(pusht::readFile(status, "status", pusht::kLargestSmallFile));
  return content.is_object() && content.value("format", nlohmann::json()) == kStatusFormat &&
         content.value("exit_code", nlohmann::json(0)) != 0 &&
         (content.value("episodes_finished", nlohmann::json()) == 0 ||
          content.value("rows_finished", nlohmann::json()) == 0);
}

void remove(const fs::path& root, const Pattern& file) {
  for (const fs::path& path : find(root, file)) {
    std::error_code error;
    fs::remove(path, error);
    if (error) {
      throw pusht::RuntimeFault("cannot replace " + path.string() + ": " + error.message());
    }
    fs::path folder = path;
    for (std::size_t part = 1; part < file.parts.size(); ++part) {
      folder = folder.parent_path();
      fs::remove(folder, error);  // fails unless it is empty
    }
  }
}

std::string nameOf(Results results) { return results == Results::kRun ? "a run" : "a sweep"; }

}  // namespace

OutputFolder::OutputFolder(fs::path path, std::string command, Results results)
    : path_(std::move(path)), command_(std::move(command)), results_(results) {
  std::error_code ignored;
  if (fs::exists(path_, ignored) && !fs::is_directory(path_, ignored)) {
    throw pusht::InvalidInput("out " + path_.string() + ": must be a folder");
  }
}

OutputFolder::~OutputFolder() {
  if (lock_ >= 0) {
    ::close(lock_);
  }
}

void OutputFolder::open() {
  create();
  lock();
  for (const Pattern& file : resultPatterns()) {
    const fs::path found = findInPlaceOfFolder(path_, file);
    if (!found.empty()) {
      throw pusht::InvalidInput("out " + path_.string() + ": results are written below " + nameIn(found) +
                                ", which is a link or a file: must be a folder; move it, or name another folder");
    }
  }
}

void OutputFolder::refuseInputs(const std::vector<Input>& inputs) const {
  if (path_.empty()) {
    return;  // a folder that is not there yet
  }
  const auto canonical = [](const fs::path& path) {
    std::error_code ignored;
    return fs::weakly_canonical(fs::absolute(path, ignored), ignored);
  };
  for (const Input& input : inputs) {
    if (input.path.empty()) {
      continue;  // there is none
    }
    const fs::path place = canonical(input.path).lexically_relative(canonical(path_));
    const std::string name = place.empty() ? "" : place.begin()->string();
    for (const Pattern& file : resultPatterns()) {
      if (std::regex_match(name, file.parts.front())) {
        throw pusht::InvalidInput(input.what + " " + input.path.string() + ": must not be where results are written (" +
                                  (path_ / name).string() + "); name another folder for the results");
      }
    }
  }
}

void OutputFolder::refuse(const std::string& why) const {
  throw pusht::InvalidInput("out " + path_.string() + ": " + why);
}

void OutputFolder::refuseOtherResults() const {
  for (const Pattern& file : resultPatterns()) {
    const std::vector<fs::path> found = find(path_, file);
    if (file.of && *file.of != results_ && !found.empty()) {
      refuse("holds " + nameOf(*file.of) + " (" + nameIn(found.front()) + "), which " + nameOf(results_) +
             " does not replace; name another folder");
    }
  }
}

void OutputFolder::refuseResults(bool overwrite) const {
  refuseOtherResults();
  for (const Pattern& file : resultPatterns()) {
    for (const fs::path& path : find(path_, file)) {
      std::error_code ignored;
      if (fs::symlink_status(path, ignored).type() == fs::file_type::directory) {
        refuse("holds a folder where results are written (" + nameIn(path) + "); move it, or name another folder");
      }
      if (!overwrite && !(file.key == "status" && tellsOfNoRun(path))) {
        refuse("holds results (" + nameIn(path) +
               "); name another folder, or replace them with --overwrite (overwrite:=true in a launch file)");
      }
    }
  }
}

bool OutputFolder::holdsResults() const {
  return std::any_of(resultPatterns().begin(), resultPatterns().end(),
                     [this](const Pattern& file) { return file.key != "status" && !find(path_, file).empty(); });
}

void OutputFolder::removeResults() const {
  for (const Pattern& file : resultPatterns()) {
    if ((!file.of || *file.of == results_) && file.key != "status") {
      remove(path_, file);
    }
  }
  removeLeftovers();
}

void OutputFolder::removeLeftovers() const {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(path_, ignored)) {
    const std::string name = entry.path().stem().string();
    const bool ours = entry.path().extension() == ".part" &&
                      std::any_of(resultPatterns().begin(), resultPatterns().end(), [&](const Pattern& file) {
                        return (!file.of || *file.of == results_) && file.parts.size() == 1 &&
                               std::regex_match(name, file.parts.front());
                      });
    if (ours && entry.symlink_status(ignored).type() == fs::file_type::regular) {  // a link is not ours
      fs::remove(entry.path(), ignored);
    }
  }
}

void OutputFolder::removeReport() const {
  for (const Pattern& file : resultPatterns()) {
    if (file.key == "report") {
      remove(path_, file);
    }
  }
}

void OutputFolder::removeReference() const {
  for (const Pattern& file : resultPatterns()) {
    if (file.key == "rollout") {
      remove(path_, file);
    }
  }
}

std::string OutputFolder::nameIn(const fs::path& path) const { return path.lexically_relative(path_).string(); }

void OutputFolder::create() {
  std::error_code error;
  if (!path_.empty()) {
    fs::create_directories(path_, error);
  } else {
    fs::create_directories("results", error);
    for (int number = 1; !error; ++number) {
      path_ = fs::path("results") / (command_ + "-" + std::to_string(number));
      if (fs::create_directory(path_, error)) {  // one of several runs at once gets it
        break;
      }
    }
  }
  if (error) {
    throw pusht::RuntimeFault("cannot create " + path_.string() + ": " + error.message());
  }
}

void OutputFolder::lock() {
  lock_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) {
    throw pusht::RuntimeFault("cannot open " + path_.string() + ": " + std::strerror(errno));
  }
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    throw pusht::InvalidInput("out " + path_.string() + ": is in use by another run");
  }
}

}  // namespace sim2sim
