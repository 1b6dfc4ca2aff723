#include "platform/cli/report/motion_plot.h"

#include <algorithm>
#include <sstream>

#include "platform/cli/report/gnuplot.h"

namespace godobject {
namespace {

constexpr int width = 1200, row_height = 320;
constexpr std::size_t most_points = 4000;  // of a line: more than its pixels

struct Shade {
  const char *title, *colour;
  std::vector<TimeSpan> PlottedMotion::*spans;
};
constexpr Shade shades[] = {{"idle", "#e8e8e8", &PlottedMotion::idle},
                            {"released", "#ffe0b0", &PlottedMotion::released},
                            {"held", "#cfe8cf", &PlottedMotion::held}};

/// Writes points of a line as a data block, at most most_points of them. In each interval of more samples the
/// least and the largest are kept. at(i): t and the value of sample i.
template <class F>
void write_line(std::ostream& out, const std::string& name, std::size_t num, F at) {
  out << '$' << name << " << EOD\n";
  const std::size_t every = std::max<std::size_t>(1, 2 * num / most_points);
  for (std::size_t first = 0; first < num; first += every) {
    const std::size_t end = std::min(first + every, num);
    std::size_t least = first, largest = first;
    for (std::size_t i = first; i < end; ++i) {
      if (at(i)[1] < at(least)[1]) least = i;
      if (at(i)[1] > at(largest)[1]) largest = i;
    }
    for (const std::size_t i : {std::min(least, largest), std::max(least, largest)}) {
      out << at(i)[0] << ' ' << at(i)[1] << '\n';
      if (least == largest) break;
    }
  }
  out << "EOD\n";
}

void write_path(std::ostream& out, const std::string& name, const std::vector<Vec3>& p) {
  out << '$' << name << " << EOD\n";
  const std::size_t every = std::max<std::size_t>(1, p.size() / most_points);
  for (std::size_t i = 0; i < p.size(); i += every) out << 1e3 * p[i].x() << ' ' << 1e3 * p[i].y() << '\n';
  out << "EOD\n";
}

/// Writes the rectangles of all intervals, and returns their entries of the key.
std::string shade(std::ostream& out, const PlottedMotion& m) {
  std::string entries;
  out << "unset object\n";
  for (const auto& [title, colour, spans] : shades) {
    for (const TimeSpan& span : m.*spans)
      out << "set object rectangle from first " << span.begin << ", graph 0 to first " << span.end
          << ", graph 1 behind fillcolor rgb '" << colour << "' fillstyle solid noborder\n";
    if (!(m.*spans).empty())
      entries += std::string("keyentry with boxes fillstyle solid fillcolor rgb '") + colour + "' title '" +
                 title + "', ";
  }
  return entries;
}

void write_motion(std::ostream& out, const PlottedMotion& m) {
  const std::vector<double>& t = m.motion.t;
  const SmoothedMotion motion = *smoothed(m.motion);
  using Point = std::array<double, 2>;
  write_line(out, "speed", static_cast<std::size_t>(motion.speed.size()), [&](std::size_t i) {
    return Point{t.front() + static_cast<double>(i) * motion.dt,
                 1e3 * motion.speed(static_cast<Eigen::Index>(i))};
  });
  write_path(out, "path", m.motion.p);
  std::string forces;
  const auto add = [&](const char* name, const char* colour, std::span<const double> F) {
    if (F.empty()) return;
    write_line(out, name, F.size(), [&](std::size_t i) { return Point{t[i], F[i]}; });
    forces += std::string(forces.empty() ? "" : ", ") + "$" + name + " with lines lc rgb '" + colour +
              "' title '" + name + "'";
  };
  add("displayed", "#1f4e9c", m.displayed_N);
  add("contact", "#c0392b", m.contact_N);

  const std::string entries = shade(out, m);
  out << "set xrange [" << t.front() << ':' << t.back() << "]\nset yrange [0:1e-6 < *]\nset xlabel 't, s'\n"
      << "set title " << gnuplot_text(m.name) << "\nset ylabel 'speed, mm/s'\n"
      << "plot " << entries << "$speed with lines lc rgb '#333333' notitle\n";
  if (forces.empty()) out << "set multiplot next\n";
  else out << "set ylabel 'force, N'\nplot " << forces << '\n';
  out << "unset object\nset xrange [*:*]\nset yrange [*:*]\nset size ratio -1\n"
      << "set xlabel 'x, mm'\nset ylabel 'y, mm'\nset title 'path from above'\n"
      << "plot $path with lines lc rgb '#333333' notitle\nset size noratio\n";
}

}  // namespace

std::vector<TimeSpan> spans_of(std::span<const double> t, const std::vector<bool>& holds) {
  std::vector<TimeSpan> spans;
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (!holds[i]) continue;
    if (i == 0 || !holds[i - 1]) spans.push_back({.begin = t[i], .end = t[i]});
    spans.back().end = i + 1 < t.size() ? t[i + 1] : t[i];
  }
  return spans;
}

std::string draw_motions(const std::string& path, std::span<const PlottedMotion> motions) {
  const int height = row_height * static_cast<int>(motions.size());
  std::ostringstream script;
  script.precision(9);
  script << "set grid\nset key top right opaque\nset multiplot layout " << motions.size() << ",3\n";
  for (const PlottedMotion& m : motions) write_motion(script, m);
  script << "unset multiplot\n";
  return draw_plot(path, width, height, script.str());
}

}  // namespace godobject
