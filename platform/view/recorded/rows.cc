// Rows of numbers in a file, and the recorded nodes of nets, whose rows are stored within a limit.
#include "platform/view/recorded/recording.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>

#include "platform/trace/trace.h"

namespace godobject {
namespace {

/// Limit on stored bytes; beyond it every other row is dropped, repeatedly.
constexpr std::size_t max_bytes = std::size_t{256} << 20;

/// Checks that the columns are those of this scene's nets. Returns empty or the error.
std::string why_not_nets(const std::vector<std::string>& names, const SceneConfig& scene,
                         const std::string& path) {
  if (scene.nets.empty())
    return path + ": scene '" + scene.name + "' has no nets: remove --nets, or add a [[net]] table";
  const std::vector<std::string> expected = net_trace_columns(scene_nets(scene));
  const auto [name, wanted] = std::ranges::mismatch(names, expected);
  if (name == names.end() && wanted == expected.end()) return "";
  const std::string is = name == names.end() ? "missing" : "'" + name->substr(0, 64) + "'";
  const std::string has = wanted == expected.end() ? "none" : "'" + *wanted + "'";
  return path + ":1: column " + std::to_string(name - names.begin() + 1) + " is " + is +
         ", and `run --nets` of scene '" + scene.name + "' writes " + has +
         " there: is it of another scene, or of other nets?";
}

/// Stores rows of numbers within max_bytes.
class Rows {
 public:
  explicit Rows(std::size_t num_columns) : numbers_(num_columns) {}

  /// Adds a line. Returns empty or the error.
  std::string add(const std::string& line) {
    if (number_++ % stride_ != 0) return "";
    if (!read_numbers(line, numbers_))
      return "not the " + std::to_string(numbers_.size()) + " numbers of a row";
    if (!std::ranges::all_of(numbers_, [](double x) { return std::isfinite(x); }))
      return "a number is not finite";
    if (!times.empty() && numbers_.front() <= times.back())
      return "its time is not after that of the row before";
    times.push_back(numbers_.front());
    for (std::size_t i = 1; i < numbers_.size(); ++i) nodes.push_back(static_cast<float>(numbers_[i]));
    if (nodes.size() * sizeof(float) > max_bytes) thin_out();
    return "";
  }

  std::vector<double> times;
  std::vector<float> nodes;

 private:
  void thin_out() {
    const std::size_t width = numbers_.size() - 1, kept = (times.size() + 1) / 2;
    for (std::size_t i = 0; i < kept; ++i) {
      times[i] = times[2 * i];
      std::copy_n(nodes.begin() + static_cast<std::ptrdiff_t>(2 * i * width), width,
                  nodes.begin() + static_cast<std::ptrdiff_t>(i * width));
    }
    times.resize(kept);
    nodes.resize(kept * width);
    stride_ *= 2;
  }

  std::vector<double> numbers_;
  std::size_t number_ = 0, stride_ = 1;
};

}  // namespace

std::vector<std::string> split_at_commas(std::string_view line) {
  std::vector<std::string> parts;
  for (;;) {
    const std::size_t comma = line.find(',');
    parts.emplace_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return parts;
    line.remove_prefix(comma + 1);
  }
}

bool read_numbers(std::string_view line, std::span<double> numbers) {
  const char *at = line.data(), *const end = at + line.size();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto [next, error] = std::from_chars(at, end, numbers[i]);
    const bool is_last = i + 1 == numbers.size();
    if (error != std::errc() || (is_last ? next != end : next == end || *next != ',')) return false;
    at = next + 1;
  }
  return true;
}

std::string read_rows(const std::string& path, const UseNames& begin, const UseRow& add, bool* is_cut) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  if (!in || !std::getline(in, line)) return path + ": cannot be read, or is empty";
  if (std::string why_not = begin(split_at_commas(line)); !why_not.empty()) return why_not;
  for (std::size_t number = 2; std::getline(in, line); ++number) {
    if (in.eof()) {  // without a line end: cut off when the run was killed
      if (is_cut != nullptr) *is_cut = true;
      break;
    }
    if (const std::string why_not = add(line); !why_not.empty())
      return path + ":" + std::to_string(number) + ": " + why_not;
  }
  return "";
}

NetRecording::NetRecording(std::vector<double> times, std::vector<float> nodes)
    : times_(std::move(times)), nodes_(std::move(nodes)) {}

std::vector<Vec3> NetRecording::at(double t) const {
  const auto after = static_cast<std::size_t>(std::ranges::lower_bound(times_, t) - times_.begin());
  const std::size_t b = std::min(after, times_.size() - 1), a = after > 0 ? std::min(after - 1, b) : 0;
  const double s = a == b ? 0 : (t - times_[a]) / (times_[b] - times_[a]);
  const std::size_t width = nodes_.size() / times_.size();
  std::vector<Vec3> nodes(width / 3);
  const auto node = [&](std::size_t row, std::size_t i) {
    const float* const x = &nodes_[row * width + 3 * i];
    return Vec3(static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2]));
  };
  for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] = (1 - s) * node(a, i) + s * node(b, i);
  return nodes;
}

NetRecordingResult read_nets(const std::string& path, const SceneConfig& scene) {
  std::optional<Rows> rows;
  std::string wrong = read_rows(
      path,
      [&](const std::vector<std::string>& names) {
        rows.emplace(names.size());
        return why_not_nets(names, scene, path);
      },
      [&](const std::string& line) { return rows->add(line); });
  if (wrong.empty() && rows->times.empty()) wrong = path + ": has no rows";
  NetRecordingResult result;
  if (!wrong.empty()) result.errors.push_back(std::move(wrong));
  else result.nets.emplace(std::move(rows->times), std::move(rows->nodes));
  return result;
}

}  // namespace godobject
