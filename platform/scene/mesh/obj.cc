// OBJ: vertices and faces. Other statements do not affect the solid and are skipped; referenced files, such
// as materials, are not opened.
#include "platform/scene/mesh/builder.h"
#include "platform/scene/mesh/text_scanner.h"
#include "platform/scene/text/diagnostics.h"

namespace godobject {
namespace {

std::string read_vertex(std::string_view line, MeshBuilder& mesh) {
  std::array<double, 3> p{};
  for (double& x : p) {
    const std::string_view word = TextScanner::first_word(line);
    const std::optional<double> read = number_of<double>(word);
    if (!read) return excerpt(word) + " is not a number";
    x = *read;
  }
  return mesh.add_vertex(p);
}

/// Parses "7", "7/1", "7//2" or "7/1/2": the first number counts vertices from 1, or backwards from the last
/// with -1.
std::optional<std::int64_t> corner_of(std::string_view word, std::int64_t num_vertices) {
  const auto number = number_of<std::int64_t>(word.substr(0, word.find('/')));
  if (!number || *number == 0 || *number < -num_vertices) return std::nullopt;
  return *number > 0 ? *number - 1 : num_vertices + *number;
}

std::string read_face(std::string_view line, std::size_t number, MeshBuilder& mesh) {
  std::vector<std::int64_t> corners;
  for (std::string_view word = TextScanner::first_word(line); !word.empty();
       word = TextScanner::first_word(line)) {
    if (word.ends_with('\\')) word.remove_suffix(1);  // the line continues
    if (word.empty()) continue;
    const std::optional<std::int64_t> corner = corner_of(word, mesh.num_vertices());
    if (!corner) return excerpt(word) + " is not a vertex number: count from 1, or from -1 backwards";
    corners.push_back(*corner);
  }
  return mesh.add_face(corners, number);
}

}  // namespace

std::string read_obj(std::string_view file, MeshBuilder& mesh) {
  TextScanner text(file);
  while (!text.rest().empty()) {
    const std::size_t number = text.line();
    std::string_view line = text.rest_of_joined_line();
    const std::string_view kind = TextScanner::first_word(line);
    std::string wrong;
    if (kind == "v") wrong = read_vertex(line, mesh);
    if (kind == "f") wrong = read_face(line, number, mesh);
    if (!wrong.empty()) return "line " + std::to_string(number) + ": " + wrong;
  }
  return "";
}

}  // namespace godobject
