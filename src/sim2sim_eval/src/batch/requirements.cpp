// SPDX-License-Identifier: BSD-3-Clause
#include "batch/requirements.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <iterator>
#include <ostream>
#include <sstream>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "sim2sim_eval/batch/command_line.hpp"

namespace sim2sim {
namespace {

using Judged = RequirementResult::Verdict;

std::size_t countOf(const std::vector<RequirementResult>& results, Judged verdict) {
  return static_cast<std::size_t>(
      std::count_if(results.begin(), results.end(),
                    [verdict](const RequirementResult& result) { return result.verdict == verdict; }));
}

/// JUnit's XML: a failure is shown otherwise, an error cannot be said.
std::string junitText(const std::string& command, const std::vector<RequirementResult>& results) {
  boost::property_tree::ptree suite;
  suite.put("<xmlattr>.name", "sim2sim " + command);
  suite.put("<xmlattr>.tests", results.size());
  suite.put("<xmlattr>.failures", countOf(results, Judged::kNotMet));
  suite.put("<xmlattr>.errors", countOf(results, Judged::kCannotSay));
  for (const RequirementResult& result : results) {
    boost::property_tree::ptree test;
    test.put("<xmlattr>.classname", "sim2sim." + command);
    test.put("<xmlattr>.name", result.requirement);
    if (result.verdict == Judged::kMet) {
      test.put("system-out", result.sentence());
    } else {
      test.put(result.verdict == Judged::kNotMet ? "failure.<xmlattr>.message" : "error.<xmlattr>.message",
               result.sentence());
    }
    suite.add_child("testcase", test);
  }
  boost::property_tree::ptree document;
  document.add_child("testsuites.testsuite", suite);
  std::ostringstream text;
  boost::property_tree::write_xml(text, document,
                                  boost::property_tree::xml_writer_make_settings<std::string>(' ', 2, "UTF-8"));
  return text.str();
}

}  // namespace

void RequirementOptions::declare(CLI::App& app) {
  app.add_option("--require", texts,
                 "what must be shown, as \"transfer > 0.8\"; may be repeated. Exit code 6: shown otherwise, 7: the "
                 "episodes cannot say")
      ->allow_extra_args(false)
      ->check(notEmpty());
  app.add_option("--junit", junit, "file for the answers to --require, as JUnit's XML")->check(notEmpty());
}

std::vector<Requirement> RequirementOptions::read() const {
  if (texts.empty() && !junit.empty()) {
    throw pusht::InvalidInput("junit " + junit.string() + ": must stand with --require, whose answers it gets");
  }
  pusht::requireNewFile("junit", junit);
  std::error_code ignored;
  if (junit.has_parent_path() && !std::filesystem::is_directory(junit.parent_path(), ignored)) {
    throw pusht::InvalidInput("junit " + junit.string() + ": must be in a folder that is there");
  }
  std::vector<Requirement> requirements;
  std::transform(texts.begin(), texts.end(), std::back_inserter(requirements),
                 [](const std::string& text) { return Requirement(text); });
  return requirements;
}

std::vector<RequirementResult> judgeAll(const std::vector<Requirement>& requirements,
                                        const std::function<RequirementResult(const Requirement&)>& judge) {
  std::vector<RequirementResult> results;
  std::transform(requirements.begin(), requirements.end(), std::back_inserter(results), judge);
  return results;
}

void report(const std::string& command, const RequirementOptions& options,
            const std::vector<RequirementResult>& results, std::ostream& out) {
  for (const RequirementResult& result : results) {
    out << "required: " << result.sentence() << "\n";
  }
  out << std::flush;
  if (!options.junit.empty()) {
    pusht::writeNewFile("junit", options.junit, junitText(command, results));
  }
}

void requireAllMet(const std::vector<RequirementResult>& results) {
  const std::size_t not_met = countOf(results, Judged::kNotMet);
  const Judged verdict = not_met > 0 ? Judged::kNotMet : Judged::kCannotSay;
  const std::size_t count = countOf(results, verdict);
  if (count == 0) {
    return;
  }
  const auto first = std::find_if(results.begin(), results.end(),
                                  [verdict](const RequirementResult& result) { return result.verdict == verdict; });
  throw pusht::Error(not_met > 0 ? pusht::ExitCode::kNotMet : pusht::ExitCode::kUndecided,
                     std::to_string(count) + " of " + std::to_string(results.size()) +
                         (results.size() == 1 ? " requirement" : " requirements") +
                         (not_met > 0 ? " not met: " : " undecided: ") + first->sentence());
}

}  // namespace sim2sim
