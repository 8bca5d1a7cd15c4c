// SPDX-License-Identifier: BSD-3-Clause
/// Reader of the zip archive of a TorchScript checkpoint. It checks the checksums, which libtorch's reader ignores.
#pragma once

#include <map>
#include <string>

namespace pusht {

/// Records of an archive by name, e.g. "archive/data/0".
using Records = std::map<std::string, std::string>;

/// All records of the archive `bytes`, uncompressed. Throws InvalidInput, naming the record and the rule, unless the
/// headers beside the records agree with the central directory, names are unique, and every record has the size and
/// the CRC-32 that the directory gives it. `name` is for messages.
Records verifiedRecords(const std::string& bytes, const std::string& name);

}  // namespace pusht
