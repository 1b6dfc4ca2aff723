#include "tests/study/map/section.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <span>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "core/integrator_implicit_euler.h"
#include "core/integrator_tr_bdf2.h"
#include "tests/study/figure.h"
#include "tests/study/map/cases.h"
#include "tests/study/map/shard.h"
#include "tests/study/report/text.h"
#include "tests/study/tool.h"

namespace godobject::study {
namespace {

namespace fs = std::filesystem;

constexpr const char* figure_name = "stability-map";
constexpr const char* integrators[] = {ImplicitEuler::name, TrBdf2::name};
constexpr double drawn_gain = 1e-12;  // smaller gains are not in the figure

/// Writes the data of the figure: for each gain the share of samples that gain as much or more.
void write_shares(const fs::path& file, const std::vector<MapSample>& samples) {
  std::ofstream out(file);
  out << "integrator,family,gain,share\n";
  for (const char* integrator : integrators)
    for (const char* family : map_families) {
      std::vector<double> gains;
      for (const MapSample& s : samples)
        if (s.fault == 0 && s.integrator == integrator && s.family == family) gains.push_back(s.gain);
      std::ranges::sort(gains, std::greater());
      for (std::size_t i = 0; i < gains.size() && gains[i] >= drawn_gain; ++i)
        out << integrator << ',' << family << ',' << gains[i] << ','
            << static_cast<double>(i + 1) / static_cast<double>(gains.size()) << '\n';
    }
  if (!out.flush()) throw std::runtime_error(file.string() + ": cannot be written");
}

void write_map_script(const fs::path& directory) {
  std::ofstream out = script(directory, figure_name, 900, 420);
  out << "set logscale xy\nset format '10^{%T}'\nset xlabel 'gain, share of the energy at work'\n"
         "set ylabel 'share of samples that gain as much or more'\n"
         "set xrange [1e-12:10]\nset yrange [1e-5:1]\nset key outside\n"
         "set arrow from "
      << MapSample::max_silent_gain << ", graph 0 to " << MapSample::max_silent_gain
      << ", graph 1 nohead dashtype 2\nset multiplot layout 1,2\n";
  for (const char* integrator : integrators) {
    out << "set title '" << integrator << "'\nplot ";
    for (const char* family : map_families)
      out << (family == map_families[0] ? "" : ", ")
          << "'stability-map-shares.csv' skip 1 using (strcol(1) eq '" << integrator << "' && strcol(2) eq '"
          << family << "' ? $3 : NaN):4 with linespoints pt 7 ps 0.3 title '" << family << "'";
    out << '\n';
  }
  out << "unset multiplot\n";
}

const MapSummary& find(const std::vector<MapSummary>& all, const std::string& family,
                       const std::string& integrator) {
  return *std::ranges::find_if(
      all, [&](const MapSummary& s) { return s.family == family && s.integrator == integrator; });
}

/// Writes a row for each family: figures of implicit Euler / TR-BDF2.
void write_families(std::ostream& out, const std::vector<MapSample>& samples) {
  const std::vector<MapSummary> all = summarise(samples);
  double median = 0;
  for (const MapSummary& one : all) median = std::max(median, one.median);
  out << "The median gain of each family is at most " << number(median, 2) << ".\n\n"
      << "| family | silent | reported | faults | worst gain | its sample |\n|---|---|---|---|---|---|\n";
  for (const char* family : map_families) {
    const MapSummary &a = find(all, family, integrators[0]), &b = find(all, family, integrators[1]);
    const auto pair = [&](const auto& x, const auto& y) { out << " | " << x << ", " << y; };
    out << "| " << family;
    pair(a.silent, b.silent);
    pair(a.reported, b.reported);
    pair(a.faults, b.faults);
    pair(number(a.worst, 2), number(b.worst, 2));
    pair(a.worst_sample, b.worst_sample);
    out << " |\n";
  }
  constexpr std::size_t listed = 8;
  std::vector<const MapSample*> silent;
  std::size_t diverging = 0;
  for (const MapSample& s : samples) {
    if (s.gains_silently()) silent.push_back(&s);
    diverging += s.fault == 0 && !(s.divergence < 2) ? 1 : 0;
  }
  std::ranges::stable_sort(silent, [](const auto* a, const auto* b) { return a->gain > b->gain; });
  out << "\nMore than twice the kinetic energy that they had or were given: " << diverging << ".\n";
  if (silent.empty()) return;
  out << "Silent, worst first:";
  for (std::size_t i = 0; i < std::min(silent.size(), listed); ++i)
    out << (i == 0 ? " " : ", ") << silent[i]->number << " (" << number(silent[i]->gain, 2) << ')';
  out << (silent.size() > listed ? ", ...\n" : ".\n");
}

/// Writes, for each drawn quantity, the share of the runs in each quarter of its values that gain or report.
void write_quarters(std::ostream& out, const std::vector<MapSample>& samples) {
  struct Quantity {
    const char* name;
    double MapSample::*value;
  };
  constexpr Quantity quantities[] = {{"step, s", &MapSample::step},
                                     {"coupling, N/m", &MapSample::coupling},
                                     {"contact, N/m", &MapSample::contact},
                                     {"mass ratio", &MapSample::mass_ratio},
                                     {"damping ratio", &MapSample::damping},
                                     {"speed of the target, m/s", &MapSample::speed},
                                     {"spin at the start, rad/s", &MapSample::spin}};
  out << "\nWhere: of the runs in each quarter of a quantity's values, those that gain above 0.1 %, reported "
         "or "
         "not; runs without the quantity are left out:\n\n"
         "| quantity | up to | 1st | up to | 2nd | up to | 3rd | up to | 4th "
         "|\n|---|---|---|---|---|---|---|---|---|\n";
  for (const Quantity& quantity : quantities) {
    std::vector<std::pair<double, bool>> runs;
    for (const MapSample& s : samples)
      if (s.*quantity.value > 0)
        runs.emplace_back(s.*quantity.value, s.fault == 0 && (s.is_reported || s.gains_silently()));
    std::ranges::sort(runs);
    out << "| " << quantity.name;
    for (std::size_t i = 0; i < 4 && !runs.empty(); ++i) {
      const std::span quarter =
          std::span(runs).subspan(runs.size() * i / 4, runs.size() * (i + 1) / 4 - runs.size() * i / 4);
      if (quarter.empty()) continue;
      out << " | " << number(quarter.back().first, 2) << " | "
          << std::ranges::count(quarter, true, &std::pair<double, bool>::second);
    }
    out << " |\n";
  }
}

/// Returns today's date, 2026-01-31.
std::string today() {
  const std::time_t now = std::time(nullptr);
  std::ostringstream text;
  text << std::put_time(std::localtime(&now), "%Y-%m-%d");
  return text.str();
}

/// Returns the value of a case, in bold with its fault or gain if it does not hold.
std::string value_of(const CaseResult& one) {
  const std::string value = number(one.value, 2);
  if (one.holds()) return value;
  if (one.run.fault != 0) return "**" + value + ", fault " + std::to_string(one.run.fault) + "**";
  return "**" + value + ", gain " + number(one.run.gain, 2) + "**";
}

void write_cases(std::ostream& out, long steps_at_rest) {
  const std::vector<CaseResult> all = study_cases(steps_at_rest);
  out << "\nExtreme cases. Each is also to gain at most 0.1 %, without a fault; bold if not:\n\n"
         "| case | value | at most |\n|---|---|---|\n";
  for (std::size_t i = 0; i < all.size() / 2; ++i) {
    const CaseResult &a = all[i], &b = all[all.size() / 2 + i];
    out << "| " << a.name << ": " << a.measure << " | " << value_of(a) << ", " << value_of(b) << " | "
        << number(a.limit) << " |\n";
  }
}

void write_section(std::ostream& out, const MapFile& map, const std::vector<MapSample>& samples,
                   long steps_at_rest) {
  out << "## Stability map\n\n`godobject-study stability-map --seed " << map.head.seed << " --samples "
      << map.head.samples
      << "`: scenes drawn over all parameters, each with both integrators; `--sample N` repeats one. Gain: "
         "largest lasting rise of E - W by the largest energy at work. Silent: above 0.1 %, neither reported "
         "(38) nor with a fault. Pairs: implicit-euler, tr-bdf2. Written on "
      << today() << ". ";
  write_families(out, samples);
  write_quarters(out, samples);
  out << "\n![gains of drawn scenes](figures/" << figure_name << ".png)\n";
  write_cases(out, steps_at_rest);
  out << '\n';
}

}  // namespace

std::vector<MapSummary> summarise(const std::vector<MapSample>& samples) {
  std::vector<MapSummary> all;
  for (const char* family : map_families)
    for (const char* integrator : integrators) {
      MapSummary one{.family = family, .integrator = integrator};
      std::vector<double> gains;
      for (const MapSample& s : samples) {
        if (s.family != family || s.integrator != integrator) continue;
        ++one.drawn;
        one.silent += s.gains_silently() ? 1 : 0;
        one.reported += s.fault == 0 && s.is_reported ? 1 : 0;
        one.faults += s.fault != 0 ? 1 : 0;
        if (s.fault != 0) continue;
        gains.push_back(s.gain);
        if (!(s.gain <= one.worst)) one.worst = s.gain, one.worst_sample = s.number;
      }
      if (!gains.empty()) {
        const auto middle = gains.begin() + static_cast<std::ptrdiff_t>(gains.size() / 2);
        std::nth_element(gains.begin(), middle, gains.end());
        one.median = *middle;
      }
      all.push_back(one);
    }
  return all;
}

void write_map_section(const fs::path& results, const fs::path& report, long steps_at_rest) {
  const MapFile map = read_map(results);
  if (!(map.head.shard == Shard{}) || map.rows.size() != map.head.samples)
    throw std::runtime_error(results.string() + ": --report needs all samples; --merge the shards first");
  std::vector<MapSample> samples;
  for (const std::string& row : map.rows) samples.push_back(parse_row(row));
  std::ifstream in(report);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t begin = text.find(map_begin), end = text.find(map_end);
  if (begin == std::string::npos || end == std::string::npos || end < begin)
    throw std::runtime_error(report.string() + ": has no lines " + map_begin + "and " + map_end +
                             "between which the section belongs: write the report with ./dev study first");
  const fs::path directory = fs::absolute(results).parent_path();
  write_shares(directory / "stability-map-shares.csv", samples);
  write_map_script(directory);
  if (tool_exists("gnuplot")) {
    const std::string problem = draw(directory, figure_name);
    if (!problem.empty()) throw std::runtime_error(problem);
    const fs::path figures = fs::absolute(report).parent_path() / "figures", picture = "stability-map.png";
    fs::create_directories(figures);
    fs::copy_file(directory / picture, figures / picture, fs::copy_options::overwrite_existing);
  } else {
    std::fprintf(stderr, "stability-map: no figure: gnuplot is not installed\n");
  }
  std::ostringstream section;
  write_section(section, map, samples, steps_at_rest);
  std::ofstream out(report);
  out << text.substr(0, begin) << map_begin << section.str() << text.substr(end);
  if (!out.flush()) throw std::runtime_error(report.string() + ": cannot be written");
}

}  // namespace godobject::study
