// SPDX-License-Identifier: BSD-3-Clause
/// The one reader of JSON that comes from outside.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace pusht {

/// The value in a JSON text; a discarded one (is_discarded()), which is no object, if the text is no JSON, has a number
/// beyond double, or is nested deeper than 100 levels: copies and texts of a value recurse.
nlohmann::json parseJson(const std::string& text);

/// parseJson(), with the keys of each object in the order of the text.
nlohmann::ordered_json parseOrderedJson(const std::string& text);

}  // namespace pusht
