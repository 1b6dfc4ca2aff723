// "Did you mean": the known name that is nearest to a mistyped one.
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace godobject {

/// The name fewest characters away from `typed` (Levenshtein's distance); none: all are more than two away.
std::optional<std::string_view> nearest_name(std::string_view typed, std::span<const std::string_view> names);

}  // namespace godobject
