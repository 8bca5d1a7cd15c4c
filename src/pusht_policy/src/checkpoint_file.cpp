// SPDX-License-Identifier: BSD-3-Clause
#include "checkpoint_file.hpp"

#include "checkpoint_provenance.hpp"
#include "file_kinds.hpp"
#include "pusht_task/files.hpp"

namespace pusht {
namespace {

/// Description in the archive; the plain contract if there is none.
PolicyDescription descriptionIn(const Records& records, const std::string& name) {
  const std::string first = records.empty() ? "" : records.begin()->first;
  const std::string root = first.substr(0, first.find('/') + 1);
  const auto found = records.find(root + "extra/" + kDescriptionFile);
  return found == records.end() ? PolicyDescription() : descriptionFrom(found->second, name + ": " + kDescriptionFile);
}

std::string bytesOf(const std::filesystem::path& path, const std::string& name) {
  requireFile(path, name);
  return readFile(path, "policy");
}

}  // namespace

CheckpointFile::CheckpointFile(const std::filesystem::path& path)
    : name("policy " + path.string()), bytes(bytesOf(path, name)), hash(sha256(bytes)) {
  requireHashOfProvenance(path, name, hash);
  requireNoOtherFormat(bytes, name);
  records = verifiedRecords(bytes, name);
  description = descriptionIn(records, name);
}

}  // namespace pusht
