// The page and all its files, embedded in the program.
#pragma once

#include <string_view>

namespace godobject {

struct PageFile {
  std::string_view text;  // empty: there is no such file
  std::string_view type;  // media type of its contents, for HTTP
};

/// Returns a file of the page. path: "/", "/app.js".
PageFile page_file(std::string_view path) noexcept;
/// True if the program was built with the page.
bool has_page() noexcept;

}  // namespace godobject
