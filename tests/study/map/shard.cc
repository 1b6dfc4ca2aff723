#include "tests/study/map/shard.h"

#include <cstdio>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "core/godobject.h"

namespace godobject::study {
namespace {

namespace fs = std::filesystem;

constexpr const char* columns =
    "sample,family,integrator,kind,step_s,coupling_N_m,contact_N_m,mass_ratio,damping_ratio,"
    "device_speed_m_s,spin_rad_s,steps,fault,reported,gain,divergence,distance_m";
constexpr std::size_t num_columns = 17;

[[noreturn]] void refuse(const fs::path& file, const std::string& why) {
  throw std::runtime_error(file.string() + ": " + why);
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream text(line);
  for (std::string field; std::getline(text, field, ',');) fields.push_back(field);
  return fields;
}

/// Reads the head's first line.
MapHead parse_head(const fs::path& file, const std::string& line) {
  MapHead head;
  unsigned long long seed = 0, samples = 0, k = 0, n = 0;
  char fingerprint[33] = {};
  if (std::sscanf(line.c_str(),
                  "# stability-map seed=%llu samples=%llu shard=%llu/%llu fingerprint=%32[0-9a-f]", &seed,
                  &samples, &k, &n, fingerprint) != 5 ||
      k < 1 || k > n)
    refuse(file, "line 1: no head of a stability map: '" + line + "'");
  head = {.seed = seed, .samples = samples, .shard = {.k = k, .n = n}, .fingerprint = fingerprint};
  return head;
}

std::string shard_text(const Shard& shard) { return std::to_string(shard.k) + "/" + std::to_string(shard.n); }

/// Returns why two files are not of the same run; empty if they are. Their shards may differ.
std::string difference(const MapHead& a, const MapHead& b) {
  const auto differ = [](const std::string& of, const auto& x, const auto& y) {
    std::ostringstream text;
    text << of << ' ' << x << ", not " << y;
    return text.str();
  };
  if (a.seed != b.seed) return differ("seed", a.seed, b.seed);
  if (a.samples != b.samples) return differ("samples", a.samples, b.samples);
  if (a.shard.n != b.shard.n) return differ("number of shards", a.shard.n, b.shard.n);
  if (a.fingerprint != b.fingerprint)
    return differ("other results: written by another program or processor, fingerprint", a.fingerprint,
                  b.fingerprint);
  return {};
}

struct Closer {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using Stream = std::unique_ptr<std::FILE, Closer>;

/// Writes a text at once, so that a kill tears at most its last line.
void write(std::FILE* stream, const std::string& text, const fs::path& file) {
  if (std::fwrite(text.data(), 1, text.size(), stream) != text.size() || std::fflush(stream) != 0)
    refuse(file, "cannot be written; free some space and start again, it will be continued");
}

}  // namespace

Shard parse_shard(const std::string& text) {
  Shard shard;
  std::istringstream in(text);
  char slash = 0;
  const bool is_read = static_cast<bool>(in >> shard.k >> slash >> shard.n) && in.peek() == EOF;
  if (!is_read || slash != '/' || text.find('-') != std::string::npos || shard.k < 1 || shard.k > shard.n)
    throw std::runtime_error("--shard " + text + ": write k/n with 1 <= k <= n, e.g. 3/16");
  return shard;
}

std::string map_columns() { return columns; }

std::string MapHead::lines() const {
  std::ostringstream text;
  text << "# stability-map seed=" << seed << " samples=" << samples << " shard=" << shard_text(shard)
       << " fingerprint=" << fingerprint << '\n'
       << columns << '\n';
  return text.str();
}

std::string row_of(const MapSample& s) {
  std::ostringstream text;
  text << std::setprecision(9) << s.number << ',' << s.family << ',' << s.integrator << ',' << s.kind << ','
       << s.step << ',' << s.coupling << ',' << s.contact << ',' << s.mass_ratio << ',' << s.damping << ','
       << s.speed << ',' << s.spin << ',' << s.steps << ',' << s.fault << ',' << s.is_reported << ','
       << s.gain << ',' << s.divergence << ',' << s.distance;
  return text.str();
}

MapSample parse_row(const std::string& line) {
  const std::vector<std::string> f = fields_of(line);
  if (f.size() != num_columns) throw std::runtime_error("no row of a stability map: '" + line + "'");
  const auto real = [&](std::size_t i) {
    char* end = nullptr;
    const double value = std::strtod(f[i].c_str(), &end);
    if (f[i].empty() || *end != '\0') throw std::runtime_error("no number: '" + f[i] + "'");
    return value;
  };
  return {.number = static_cast<std::uint64_t>(real(0)),
          .family = f[1],
          .integrator = f[2],
          .kind = f[3],
          .step = real(4),
          .coupling = real(5),
          .contact = real(6),
          .mass_ratio = real(7),
          .damping = real(8),
          .speed = real(9),
          .spin = real(10),
          .steps = static_cast<int>(real(11)),
          .fault = static_cast<std::uint32_t>(real(12)),
          .is_reported = real(13) != 0,
          .gain = real(14),
          .divergence = real(15),
          .distance = real(16)};
}

std::string map_fingerprint() {
  std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a
  for (std::uint64_t number = 0; number < 2 * num_map_families; ++number)
    for (const char c : row_of(map_sample(0, number)))
      hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  std::ostringstream text;
  text << std::hex << std::setw(16) << std::setfill('0') << hash;
  return text.str();
}

MapFile read_map(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) refuse(file, "cannot be read");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  MapFile map;
  std::vector<std::string> lines;
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1)
    lines.push_back(text.substr(begin, end - begin));
  if (lines.size() < 2) {
    if (!lines.empty()) parse_head(file, lines[0]);
    else if (!text.empty() && std::string("# stability-map").compare(0, 15, text, 0, 15) != 0)
      refuse(file, "no result of a stability map");
    return map;
  }
  map.head = parse_head(file, lines[0]);
  if (lines[1] != columns) refuse(file, "line 2: other columns, of another version of the program");
  map.whole_bytes = begin;
  for (std::size_t i = 2; i < lines.size(); ++i) {
    const std::uint64_t expected = map.head.shard.number(i - 2);
    try {
      if (parse_row(lines[i]).number != expected || expected >= map.head.samples)
        throw std::runtime_error("not the row of sample " + std::to_string(expected));
    } catch (const std::runtime_error& error) {
      refuse(file, "line " + std::to_string(i + 1) + ": " + error.what());
    }
    map.rows.push_back(lines[i]);
  }
  return map;
}

bool begins_with(const MapHead& head, const fs::path& file) {
  std::string first(head.lines().size(), '\0');
  std::ifstream(file, std::ios::binary).read(first.data(), static_cast<std::streamsize>(first.size()));
  return first == head.lines();
}

void run_shard(const MapHead& head, const fs::path& file, const MapProgress& progress) {
  std::uint64_t row = 0;
  const bool continues = fs::exists(file);
  if (continues) {
    const MapFile before = read_map(file);
    if (before.whole_bytes > 0) {
      if (!(before.head == head)) {
        const std::string why = difference(before.head, head);
        refuse(file,
               (why.empty() ? "shard " + shard_text(before.head.shard) + ", not " + shard_text(head.shard)
                            : why) +
                   "; remove the file or write to another one");
      }
      row = before.rows.size();
    }
    fs::resize_file(file, before.whole_bytes);
  }
  const Stream stream(std::fopen(file.c_str(), "ab"));
  if (!stream) refuse(file, "cannot be written");
  if (fs::file_size(file) == 0) write(stream.get(), head.lines(), file);
  const std::uint64_t rows = head.shard.size(head.samples);
  for (progress(row, rows); row < rows; progress(++row, rows))
    write(stream.get(), row_of(map_sample(head.seed, head.shard.number(row))) + '\n', file);
}

void merge_shards(const std::vector<fs::path>& files, const fs::path& out) {
  std::vector<MapFile> shards;
  std::vector<fs::path> names;  // by shard
  for (const fs::path& file : files) {
    if (fs::exists(out) && fs::equivalent(file, out)) refuse(file, "is also the file to write");
    const MapFile map = read_map(file);
    if (map.whole_bytes == 0) refuse(file, "is incomplete: it has no whole head; run its shard again");
    if (shards.empty()) {
      shards.resize(map.head.shard.n);
      names.resize(map.head.shard.n);
    }
    for (const fs::path& other : names)
      if (!other.empty()) {
        const std::string why = difference(map.head, read_map(other).head);
        if (!why.empty()) refuse(file, why + " as " + other.string());
        break;
      }
    const std::size_t k = map.head.shard.k - 1;
    if (!names[k].empty())
      refuse(file, "overlaps " + names[k].string() + ": both are shard " + shard_text(map.head.shard));
    if (map.rows.size() != map.head.shard.size(map.head.samples))
      refuse(file, "is incomplete: " + std::to_string(map.rows.size()) + " of " +
                       std::to_string(map.head.shard.size(map.head.samples)) +
                       " samples; run its shard again, it will be continued");
    shards[k] = map;
    names[k] = file;
  }
  std::string missing;
  for (std::size_t k = 0; k < names.size(); ++k)
    if (names[k].empty())
      missing += (missing.empty() ? "" : ", ") + shard_text({.k = k + 1, .n = names.size()});
  if (!missing.empty() || shards.empty())
    throw std::runtime_error("--merge: missing " + (missing.empty() ? "files" : "shards " + missing));
  MapHead head = shards[0].head;
  head.shard = {};
  std::ofstream stream(out, std::ios::binary | std::ios::trunc);
  stream << head.lines();
  for (std::uint64_t number = 0; number < head.samples; ++number)
    stream << shards[number % shards.size()].rows[number / shards.size()] << '\n';
  if (!stream.flush()) refuse(out, "cannot be written");
}

}  // namespace godobject::study
