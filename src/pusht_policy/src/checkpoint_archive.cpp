// SPDX-License-Identifier: BSD-3-Clause
#include "checkpoint_archive.hpp"

#include <zip.h>

#include <memory>
#include <utility>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

struct Discard {
  void operator()(zip_t* archive) const { zip_discard(archive); }
  void operator()(zip_file_t* record) const { zip_fclose(record); }
};
using Archive = std::unique_ptr<zip_t, Discard>;

std::string textOf(zip_error_t error) {
  std::string text = zip_error_strerror(&error);
  zip_error_fini(&error);
  return text;
}

/// libzip compares the headers with the directory when it opens an archive so.
Archive open(const std::string& bytes, const std::string& name) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* const source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  zip_t* const archive = source == nullptr ? nullptr : zip_open_from_source(source, ZIP_RDONLY | ZIP_CHECKCONS, &error);
  if (archive == nullptr) {
    zip_source_free(source);
    throw InvalidInput(name + ": must be TorchScript, a sound zip archive: " + textOf(error));
  }
  zip_error_fini(&error);
  return Archive(archive);
}

/// libzip compares the CRC-32 when the last byte has been read and the end is met.
std::string readRecord(zip_t& archive, zip_uint64_t index, const std::string& where, std::size_t limit) {
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_stat_index(&archive, index, 0, &stat) != 0 || stat.size > limit) {
    throw InvalidInput(where + ": must be at most " + std::to_string(limit) + " bytes long");
  }
  const std::unique_ptr<zip_file_t, Discard> record(zip_fopen_index(&archive, index, 0));
  if (record == nullptr) {
    throw InvalidInput(where + ": cannot be read: " + zip_strerror(&archive));
  }
  std::string content(stat.size + 1, '\0');  // a byte more, so that the end is met
  std::size_t size = 0;
  zip_int64_t count = 0;
  while ((count = zip_fread(record.get(), content.data() + size, content.size() - size)) > 0) {
    size += static_cast<std::size_t>(count);
  }
  if (count < 0 || size != stat.size) {
    throw InvalidInput(where + ": must have the size and the CRC-32 that the archive names, but is damaged: " +
                       zip_file_strerror(record.get()));
  }
  content.resize(size);
  return content;
}

}  // namespace

Records verifiedRecords(const std::string& bytes, const std::string& name) {
  constexpr std::size_t kMostExpansion = 1100;  // deflate cannot do more: a longer record is a lie
  const Archive archive = open(bytes, name);
  Records records;
  const auto count = static_cast<zip_uint64_t>(zip_get_num_entries(archive.get(), 0));
  for (zip_uint64_t index = 0; index < count; ++index) {
    const char* const record = zip_get_name(archive.get(), index, 0);
    const std::string where = name + ": record " + (record == nullptr ? std::to_string(index) : record);
    if (record == nullptr || records.count(record) != 0) {
      throw InvalidInput(where + ": must have a name of its own");
    }
    records.emplace(record, readRecord(*archive, index, where, bytes.size() * kMostExpansion));
  }
  return records;
}

}  // namespace pusht
