// Tables that a command writes into a page of the documentation.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace godobject::study {

/// Replaces the text between the lines `<!-- NAME -->` and `<!-- /NAME -->` of a page. Throws
/// std::runtime_error if the page cannot be read or written, or lacks a mark.
inline void replace_marked(const std::filesystem::path& page, const std::string& name,
                           const std::string& text) {
  std::stringstream read;
  read << std::ifstream(page).rdbuf();
  std::string content = read.str();
  const std::string open = "<!-- " + name + " -->\n", close = "<!-- /" + name + " -->";
  const std::size_t from = content.find(open), to = content.find(close);
  if (from == std::string::npos || to == std::string::npos || to < from)
    throw std::runtime_error(page.string() + ": has no lines '" + open.substr(0, open.size() - 1) +
                             "' and '" + close + "': add them where the table shall be");
  content.replace(from + open.size(), to - from - open.size(), "\n" + text + "\n");
  std::ofstream out(page);
  out << content;
  if (!out.flush()) throw std::runtime_error(page.string() + ": cannot be written");
}

}  // namespace godobject::study
