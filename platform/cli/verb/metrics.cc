// godobject metrics: computes metrics of motion and force from a trace, for the assessment of skill.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "platform/cli/command_line.h"
#include "platform/cli/program.h"
#include "platform/cli/report/gnuplot.h"
#include "platform/cli/report/motion_plot.h"
#include "platform/scene/toml.h"
#include "platform/trace/metrics.h"
#include "platform/view/recorded/recording.h"

namespace godobject {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* metric_definitions =
    "Path and angular path are integrals of speed and angular speed. Idle is the share of the time below "
    "--idle-below (Oropesa et al., Surgical Innovation 20, 2013). Log dimensionless jerk is -ln(T^3 / "
    "v_peak^2 "
    "integral of jerk^2 dt), higher is smoother (Balasubramanian et al., J. NeuroEngineering and "
    "Rehabilitation "
    "12:112, 2015; Hogan and Sternad, J. Motor Behavior 41, 2009); a minimum-jerk reach has -5.32. Forces "
    "are "
    "the displayed one and the sum of a body's contacts: peak, mean over all rows, time above --force-above "
    "(Horeman et al., Visual force feedback in laparoscopic training, 2012). A contact continues through "
    "gaps "
    "below 50 ms. Releases and engagements end and begin times with the device's switches engaged and "
    "clutch. "
    "Grabs are changes of held to a body. Poses are smoothed by polynomials of degree 5 over 0.3 s (Savitzky "
    "and Golay, Analytical Chemistry 36, 1964), which passes half of the power at 5.6 Hz; forces are not.";

struct MetricsOptions {
  std::string file;            // trace or log
  std::string json, picture;   // files to write; empty: none
  std::string scene;           // of a log
  std::optional<double> from;  // s
  std::optional<double> to;    // s
  double idle_below = 0.005;   // m/s
  double force_above = 2;      // N
  FaultChecks faults{};        // simulation of the program
};

/// A body or a device in a trace: its columns, and its samples.
struct Subject {
  std::string name;
  std::size_t pose = 0;                                                // first of seven columns
  std::optional<std::size_t> force{}, contact{}, engaged{}, clutch{};  // first column of each

  MotionSamples motion{};
  std::vector<double> force_N{}, contact_N{};  // lengths
  std::vector<bool> is_engaged{}, touches{};
};

/// Samples of a trace, a row at a time.
class TraceSamples {
 public:
  explicit TraceSamples(const MetricsOptions& options) : options_(options) {}

  /// Finds the columns: each driven body and device, or, without any, each body. Returns empty or the error.
  std::string begin(const std::vector<std::string>& names) {
    names_ = &names;
    numbers_.resize(names.size());
    if (names.front() != "t") return "is no trace, whose first column is t";
    if ((held_ = find("held"))) grabs = 0;
    for (const char* of : {".target.x", ".device.x"})
      for (const std::string& name : names)
        if (name.ends_with(of)) add_subject(name.substr(0, name.size() - std::string_view(of).size()), of);
    if (subjects.empty())
      for (const std::string& name : names)
        if (name.ends_with(".vx")) add_subject(name.substr(0, name.size() - 3), "");
    names_ = nullptr;
    return subjects.empty() ? "is no trace: it has no columns of a body" : "";
  }

  /// Adds a row. Returns empty or the error.
  std::string add(const std::string& line) {
    if (!read_numbers(line, numbers_))
      return "not the " + std::to_string(numbers_.size()) + " numbers of a row";
    const double t = numbers_.front();
    if (!std::isfinite(t) || (t_before_ && t <= *t_before_))
      return "its time is not after that of the row before";
    t_before_ = t;
    if (t < options_.from.value_or(t) || t > options_.to.value_or(t)) return "";
    times.push_back(t);
    for (Subject& subject : subjects)
      if (!add_to(subject)) return "a number of " + subject.name + " is not finite, or its quaternion is 0";
    if (!held_) return "";
    const double held = numbers_[*held_];
    is_held.push_back(held >= 0);
    if (held >= 0 && held != held_before_) ++*grabs;
    held_before_ = held;
    return "";
  }

  std::vector<double> times;
  std::vector<Subject> subjects;
  std::optional<std::size_t> grabs{};  // absent: the device does not grip
  std::vector<bool> is_held{};         // of each row, if the device grips

 private:
  std::optional<std::size_t> find(const std::string& name) const {
    const auto found = std::ranges::find(*names_, name);
    if (found == names_->end()) return std::nullopt;
    return static_cast<std::size_t>(found - names_->begin());
  }

  /// name: body or device. of: ".device.x" for the device's own pose. Its switches are also a driven body's.
  void add_subject(const std::string& name, std::string_view of) {
    const bool is_device = of == ".device.x";
    const std::string shown = is_device ? name + ".device" : name;
    const auto pose = find(shown + ".x");
    if (!pose || *pose + 7 > numbers_.size()) return;
    Subject subject{.name = printable(shown), .pose = *pose};
    const bool is_driven = find(name + ".target.x").has_value();
    if (!is_device) subject.force = find(name + ".feedback.fx");
    else if (!is_driven) subject.force = find("hand.fx");
    if (!is_device) subject.contact = find(name + ".contact.fx");
    if (is_driven != is_device) {
      subject.engaged = find(name + ".engaged");
      subject.clutch = find(name + ".clutch");
    }
    subjects.push_back(std::move(subject));
  }

  /// Returns false if a number is not finite, or if the quaternion is zero.
  bool add_to(Subject& s) const {
    const double* const x = &numbers_[s.pose];
    const Quat q(x[3], x[4], x[5], x[6]);
    if (!Vec3(x[0], x[1], x[2]).allFinite() || !q.coeffs().allFinite() || !(q.norm() > 0)) return false;
    s.motion.t.push_back(times.back());
    s.motion.p.emplace_back(x[0], x[1], x[2]);
    s.motion.q.push_back(q.normalized());
    const auto length = [&](std::size_t column) {
      return std::hypot(numbers_[column], numbers_[column + 1], numbers_[column + 2]);
    };
    if (s.force) s.force_N.push_back(length(*s.force));
    if (s.contact) s.contact_N.push_back(length(*s.contact));
    if (s.contact) s.touches.push_back(s.contact_N.back() > 0);
    if (s.engaged)
      s.is_engaged.push_back(numbers_[*s.engaged] != 0 && (!s.clutch || numbers_[*s.clutch] != 0));
    return (!s.force || std::isfinite(s.force_N.back())) && (!s.contact || std::isfinite(s.contact_N.back()));
  }

  const MetricsOptions& options_;
  const std::vector<std::string>* names_ = nullptr;
  std::vector<double> numbers_;
  std::optional<double> t_before_{};
  std::optional<std::size_t> held_{};
  double held_before_ = -1;
};

Json to_json(const ForceMetrics& force) {
  return {{"peak_N", force.peak}, {"mean_N", force.mean}, {"above_s", force.above}};
}

/// Returns the metrics of a body or device; null if its motion has none.
Json metrics_of(const Subject& subject, const MetricsOptions& options) {
  const std::optional<MotionMetrics> m = motion_metrics(subject.motion, options.idle_below);
  if (!m) return nullptr;
  const std::vector<double>& t = subject.motion.t;
  Json json{{"name", subject.name},
            {"path_m", m->path},
            {"angle_rad", m->angle},
            {"mean_speed_m_per_s", m->mean_speed},
            {"peak_speed_m_per_s", m->peak_speed},
            {"idle_percent", 100 * m->idle_share},
            {"log_dimensionless_jerk",
             m->log_dimensionless_jerk ? Json(*m->log_dimensionless_jerk) : Json(nullptr)}};
  if (subject.force)
    json["displayed_force"] = to_json(force_metrics(t, subject.force_N, options.force_above));
  if (subject.contact) {
    const Episodes contacts = episodes(t, subject.touches, least_gap);
    json["contact_force"] = to_json(force_metrics(t, subject.contact_N, options.force_above));
    json["contacts"] = {{"begun", contacts.begun}, {"time_s", contacts.time}};
  }
  if (subject.engaged) {
    const Episodes engaged = episodes(t, subject.is_engaged, 0);
    json["clutch"] = {{"releases", engaged.ended}, {"engagements", engaged.begun}};
  }
  return json;
}

/// Returns a row of the table: the label and a number for each subject; empty if none has it.
/// key: names of the number, one within the other.
std::string row(const char* label, const Json& subjects, std::initializer_list<const char*> key,
                double factor = 1) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%-34s", label);
  std::string line = text.data();
  bool any = false;
  for (const Json& subject : subjects) {
    const Json* value = &subject;
    for (const char* name : key)
      if (value->contains(name)) value = &(*value)[name];
    const bool has = value->is_number();
    any = any || has;
    if (has) std::snprintf(text.data(), text.size(), " %14.5g", factor * value->get<double>());
    else std::snprintf(text.data(), text.size(), " %14s", "-");
    line += text.data();
  }
  return any ? line + "\n" : "";
}

std::string table_of(const Json& json) {
  const Json& subjects = json["subjects"];
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(), ": %.6g s, %zu rows\n%-34s", json["time_s"].get<double>(),
                json["rows"].get<std::size_t>(), "");
  std::string table = json["file"].get<std::string>() + text.data();
  for (const Json& subject : subjects) {
    std::snprintf(text.data(), text.size(), " %14.60s", subject["name"].get<std::string>().c_str());
    table += text.data();
  }
  table += "\n";
  std::array<char, 40> idle{}, above{};
  std::snprintf(idle.data(), idle.size(), "idle, below %g mm/s, %%",
                1e3 * json["idle_below_m_per_s"].get<double>());
  std::snprintf(above.data(), above.size(), "  time above %g N, s", json["force_above_N"].get<double>());
  const auto forces = [&](const char* label, const char* key) {
    return row(label, subjects, {key, "peak_N"}) + row("  mean, N", subjects, {key, "mean_N"}) +
           row(above.data(), subjects, {key, "above_s"});
  };
  table += row("path, m", subjects, {"path_m"}) + row("angular path, rad", subjects, {"angle_rad"}) +
           row("mean speed, mm/s", subjects, {"mean_speed_m_per_s"}, 1e3) +
           row("peak speed, mm/s", subjects, {"peak_speed_m_per_s"}, 1e3) +
           row(idle.data(), subjects, {"idle_percent"}) +
           row("log dimensionless jerk", subjects, {"log_dimensionless_jerk"}) +
           forces("displayed force: peak, N", "displayed_force") +
           forces("contact force: peak, N", "contact_force") +
           row("contacts begun", subjects, {"contacts", "begun"}) +
           row("  time in contact, s", subjects, {"contacts", "time_s"}) +
           row("releases of the device", subjects, {"clutch", "releases"}) +
           row("  engagements", subjects, {"clutch", "engagements"});
  if (!json["grabs"].is_null()) table += "grabs: " + json["grabs"].dump() + "\n";
  return table;
}

/// Reads the trace, or recomputes that of a log of buses. Returns the errors.
std::vector<std::string> read(const MetricsOptions& options, TraceSamples& trace) {
  const auto begin = [&](const std::vector<std::string>& names) {
    const std::string why = trace.begin(names);
    return why.empty() ? "" : options.file + ": " + why + "; a log of buses requires --scene";
  };
  const auto add = [&](const std::string& line) { return trace.add(line); };
  std::vector<std::string> errors;
  if (options.scene.empty()) {
    if (std::string wrong = read_rows(options.file, begin, add); !wrong.empty()) errors.push_back(wrong);
    return errors;
  }
  const LoadResult loaded = load_scene(options.scene, options.faults);
  if (!loaded.scene || !loaded.errors.empty()) return loaded.errors;
  const RecordingResult result = replay_rows(options.file, options.scene, *loaded.scene, begin, add);
  for (const std::string& note : result.notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  return result.errors;
}

/// Draws the picture. Returns the error; empty on success.
std::string draw(const TraceSamples& trace, const MetricsOptions& options) {
  std::vector<PlottedMotion> motions;
  for (const Subject& s : trace.subjects) {
    const std::vector<double>& t = s.motion.t;
    const SmoothedMotion motion = *smoothed(s.motion);
    std::vector<double> times;
    std::vector<bool> is_idle, is_released = s.is_engaged;
    is_released.flip();
    for (Eigen::Index i = 0; i < motion.speed.size(); ++i) {
      times.push_back(t.front() + static_cast<double>(i) * motion.dt);
      is_idle.push_back(motion.speed(i) < options.idle_below);
    }
    motions.push_back({.name = s.name,
                       .motion = s.motion,
                       .displayed_N = s.force_N,
                       .contact_N = s.contact_N,
                       .held = trace.grabs ? spans_of(t, trace.is_held) : std::vector<TimeSpan>{},
                       .released = s.engaged ? spans_of(t, is_released) : std::vector<TimeSpan>{},
                       .idle = spans_of(times, is_idle)});
  }
  return draw_motions(options.picture, motions);
}

ExitCode show(const MetricsOptions& options) {
  if (!options.picture.empty() && !is_plot(options.picture)) {
    std::fprintf(stderr, "--picture: '%s' must end in .svg or .png\n", options.picture.c_str());
    return ExitCode::usage;
  }
  TraceSamples trace(options);
  const std::vector<std::string> errors = read(options, trace);
  for (const std::string& error : errors) std::fprintf(stderr, "%s\n", error.c_str());
  if (!errors.empty()) return ExitCode::usage;
  Json json{{"file", options.file},
            {"time_s", trace.times.empty() ? 0 : trace.times.back() - trace.times.front()},
            {"rows", trace.times.size()},
            {"smoothing_window_s", smoothing_window},
            {"idle_below_m_per_s", options.idle_below},
            {"force_above_N", options.force_above},
            {"grabs", trace.grabs ? Json(*trace.grabs) : Json(nullptr)},
            {"subjects", Json::array()}};
  for (const Subject& subject : trace.subjects) json["subjects"].push_back(metrics_of(subject, options));
  if (json["subjects"].front().is_null()) {
    std::fprintf(
        stderr,
        "%s: %zu rows over %.3g s; metrics require %g s or more at %g rows/s or more: record longer, "
        "lower --trace-every, or widen --from and --to\n",
        options.file.c_str(), trace.times.size(), json["time_s"].get<double>(), smoothing_window,
        least_sample_rate);
    return ExitCode::usage;
  }
  std::fputs(table_of(json).c_str(), stdout);
  const std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  if (!options.json.empty() && !write_file("--json", options.json, text)) return ExitCode::fault;
  if (options.picture.empty()) return ExitCode::ok;
  const std::string error = draw(trace, options);
  if (!error.empty()) std::fprintf(stderr, "--picture: %s\n", error.c_str());
  return error.empty() ? ExitCode::ok : ExitCode::not_available;
}

}  // namespace

void add_metrics(CLI::App& app, const FaultChecks& checks, ExitCode& code) {
  CLI::App* verb = app.add_subcommand(
      "metrics", "Compute path, speed, smoothness, force, clutches and contacts of a trace or recording.");
  verb->footer(metric_definitions);
  const auto options = std::make_shared<MetricsOptions>();
  options->faults = checks;
  verb->add_option("FILE", options->file, "read this trace, of run --trace, or with --scene a log of buses")
      ->required();
  verb->add_option("--scene", options->scene, "replay FILE, of run --record, in this scene file (TOML)");
  verb->add_option("--json", options->json, "write a JSON of the metrics")->type_name("FILE");
  verb->add_option("--picture", options->picture,
                   "draw speed, force and path to this file, .svg or .png, with gnuplot")
      ->type_name("FILE");
  verb->add_option("--from", options->from, "omit rows before this time, s")->check(number_in(-1e9, 1e9));
  verb->add_option("--to", options->to, "omit rows after this time, s")->check(number_in(-1e9, 1e9));
  verb->add_option("--idle-below", options->idle_below, "count speeds below this one as idle, m/s")
      ->capture_default_str()
      ->check(number_above(0, 1e3));
  verb->add_option("--force-above", options->force_above, "measure the time of forces above this one, N")
      ->capture_default_str()
      ->check(number_in(0, 1e6));
  verb->callback([options, &code] { code = show(*options); });
}

}  // namespace godobject
