// "Did you mean": finds the known name nearest to a mistyped one.
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace godobject {

/// Returns the name with the smallest Levenshtein distance to `typed`; none if all are more than two away.
std::optional<std::string_view> nearest_name(std::string_view typed, std::span<const std::string_view> names);

}  // namespace godobject
