// godobject replay: repeats a run from its input log, and compares each cycle.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

#include "platform/cli/command_line.h"
#include "platform/cli/program.h"
#include "platform/cli/report/files.h"
#include "platform/cli/report/report.h"
#include "platform/cli/report/revision.h"
#include "platform/scene/toml.h"
#include "platform/trace/input_log.h"
#include "platform/trace/rig_replay.h"

namespace godobject {
namespace {

struct ReplayOptions {
  std::string file, scene;  // scene: empty for the recorded one
  std::optional<double> from, to;
  RunFileNames files;
  FaultChecks faults{};
};

/// Returns a head with this program's version and revision.
InputLogHead this_build() {
  InputLogHead head;
  head.version = GODOBJECT_VERSION;
  head.revision = revision();
  return head;
}
bool is_of_this_build(const InputLogHead& head) {
  return head.version == GODOBJECT_VERSION && head.revision == revision();
}
std::string build_of(const InputLogHead& head) {
  const std::string of_sources = head.revision.empty() ? "no revision" : "revision " + head.revision;
  return printable(head.version + ", " + of_sources);
}

std::vector<std::string> names_of_bodies(const SceneConfig& scene) {
  std::vector<std::string> names;
  for (const BodyConfig& body : scene.bodies) names.push_back(body.name);
  return names;
}

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

/// Returns why the inputs of a recorded scene are none of another; empty if they are.
std::string why_no_inputs_of(const SceneConfig& recorded, const SceneConfig& other) {
  const auto kind = [](const SceneConfig& scene) {
    return scene.device ? device_kind_names[static_cast<std::size_t>(scene.device->kind)] : "none";
  };
  if (names_of_bodies(recorded) != names_of_bodies(other))
    return "its bodies are " + list_of(names_of_bodies(other)) + "; the recorded ones are " +
           list_of(names_of_bodies(recorded));
  if (driven_bodies(recorded) != driven_bodies(other) || grips_bodies(recorded) != grips_bodies(other))
    return "its device moves other bodies than the recorded one";
  if (std::string_view(kind(recorded)) != kind(other))
    return std::string("the kind of its device is ") + kind(other) + "; the recorded one is " +
           kind(recorded);
  if (recorded.step != other.step) return "its step differs from the recorded one";
  return "";
}

/// Repeats the cycles of a log on an engine.
class Replay {
 public:
  /// files: null without a trace. Both scene and reader must outlive this object.
  Replay(const ReplayOptions& options, const SceneConfig& scene, InputLogReader& reader,
         std::unique_ptr<Engine> engine, RunFiles* files)
      : options_(options),
        scene_(scene),
        reader_(reader),
        engine_(std::move(engine)),
        files_(files),
        bodies_(names_of_bodies(scene)),
        driven_(driven_bodies(scene)),
        joints_(scene),
        compares_(options.scene.empty()),
        words_(num_words(reader.head().sizes)) {}

  ExitCode run() {
    start();
    if (compares_ && RigReplay::why_not(scene_, reader_.head().device_start).empty())
      rig_.emplace(scene_, reader_.head().device_start);
    if (compares_ && options_.from)
      begin_ = reader_.continue_at(static_cast<std::uint64_t>(*options_.from / scene_.step));
    if (rig_) reader_.begin_again();  // its state depends on all frames before
    for (bool more = !has_ended_; more;) {
      switch (reader_.next()) {
        case InputLogReader::Item::row: more = take_row(); break;
        case InputLogReader::Item::state: more = take_state(); break;
        case InputLogReader::Item::links:
          if (rig_) rig_->add(reader_.first_link(), reader_.links());
          break;
        case InputLogReader::Item::end: more = end_rig(); break;
        case InputLogReader::Item::cut:
          note("was cut after cycle " + std::to_string(last_) + ", or is still written");
          more = end_rig();
          break;
      }
    }
    return end();
  }

 private:
  void note(const std::string& text) const {
    std::fprintf(stderr, "note: %s %s\n", options_.file.c_str(), text.c_str());
  }

  bool is_before(double t) const { return t < options_.from.value_or(-1) - 0.5 * scene_.step; }
  bool is_shown(double t) const {
    return !is_before(t) && t < options_.to.value_or(1e12) + 0.5 * scene_.step;
  }

  /// Compares the start, and begins the trace with it.
  void start() {
    record_ = reader_.start();
    observe(StepReport{});
    if (compares_) compare(reader_.start());
    if (files_ && is_shown(0)) files_->add(record_);
  }

  /// Repeats a cycle: the engine if it has the state before it, and the rig. Returns false after the last.
  bool take_row() {
    const CycleRecord& row = reader_.row();
    if (row.t > options_.to.value_or(1e12) + 0.5 * scene_.step) return false;
    last_ = row.cycle;
    const bool goes_on = step_engine(row);
    return goes_on && step_rig(row);
  }

  bool step_engine(const CycleRecord& row) {
    if (row.cycle <= std::max(now_, begin_)) return true;
    if (has_state_ && row.cycle != now_ + 1) has_state_ = false;
    if (!has_state_) return compares_ || stop_at_gap();
    now_ = row.cycle;
    record_ = row;
    if (row.passed_s > 0) engine_->pass_time(row.passed_s);
    const StepReport report = engine_->step(row.samples);
    observe(report);
    if (compares_) compare(row);
    if (is_shown(row.t)) {
      if (num_cycles_++ == 0) first_t_ = row.t;
      last_t_ = row.t;
      if (files_) files_->add(record_);
    }
    return !has_ended_;
  }

  /// Continues with a recorded state unless the engine has it. Returns false if it cannot.
  bool take_state() {
    const EngineState& state = reader_.state();
    if (!compares_ || state.cycle < std::max(now_, begin_) || (has_state_ && state.cycle == now_))
      return true;
    const InputLogHead& head = reader_.head();
    if (!is_of_this_build(head) || head.composition != engine_->composition().name ||
        !engine_->restore(state.bytes) || engine_->state_hash() != state.hash) {
      note("has states of another build (" + build_of(head) + "; this is " + build_of(this_build()) +
           "), so it is replayed from its start only");
      failed_ = true;
      return false;
    }
    if (num_cycles_ > 0 || now_ > 0 || !has_state_) tell_gap(state.cycle);
    else if (!options_.from) note("begins after cycle " + std::to_string(state.cycle));
    now_ = state.cycle;
    has_state_ = true;
    return true;
  }

  /// Repeats the rig's part of a cycle. Returns false at a difference, from the first shown cycle on.
  bool step_rig(const CycleRecord& row) {
    if (!rig_ || !rig_->has_events()) return true;
    const std::string found = rig_->step(row, !is_before(row.t));
    if (!found.empty()) show_difference(row.cycle, row.t, found);
    return found.empty();
  }
  /// Repeats the rig's calls after the last row. Returns false.
  bool end_rig() {
    const std::string found = rig_ && rig_->has_events() ? rig_->end() : "";
    if (!found.empty()) show_difference(last_, static_cast<double>(last_) * scene_.step, "after it " + found);
    return false;
  }

  void tell_gap(std::uint64_t last) {
    std::printf("gap: cycles %llu to %llu are not replayed, because rows before them are missing\n",
                static_cast<unsigned long long>(now_ + 1), static_cast<unsigned long long>(last));
    failed_ = true;
  }
  bool stop_at_gap() {
    note("lacks the inputs after cycle " + std::to_string(now_) + "; another scene cannot continue after it");
    failed_ = true;
    return false;
  }

  /// Writes the engine's outputs into the record, which has the recorded inputs.
  void observe(const StepReport& report) {
    for (std::size_t i = 0; i < record_.bodies.size(); ++i) record_.bodies[i] = engine_->view(i);
    record_.state_hash = engine_->state_hash();
    for (std::size_t i = 0; i < record_.targets.size(); ++i) {
      const BodySample& sample = record_.samples[driven_[i]];
      record_.targets[i] = {.X_WD = sample.target.X_WD,
                            .F_WB = sample.F_WB,
                            .engaged = sample.engaged,
                            .clutch = sample.clutch};
    }
    if (grips_bodies(scene_) && !record_.targets.empty())
      record_.targets.front().engaged = record_.held.has_value();
    record_.fault = report.fault;
    if (!compares_) record_.limited = report.limited;
    record_.contacts = report.contacts;
    record_.nets = report.nets;
    record_.energy = engine_->energy();
    record_.net_stretch = engine_->net_stretch();
    record_.term_forces.resize(term_names(scene_).size());
    engine_->term_forces(record_.term_forces);
    if (record_.joint_q.size() == joints_.size()) joints_.read(record_.bodies, record_.joint_q);
    if (!files_) return;
    if (files_->wants_contacts()) record_.touching.resize(engine_->composition().all_contacts());
    record_.num_touching = engine_->contacts(record_.touching);
    if (files_->wants_net_nodes()) record_.net_nodes.resize(engine_->nets().nodes.size());
    engine_->net_nodes(record_.net_nodes);
  }

  /// Compares the record with the recorded row, and prints the first difference.
  void compare(const CycleRecord& row) {
    to_words(record_, words_);
    const auto first = static_cast<std::ptrdiff_t>(first_output_word(reader_.head().sizes));
    const auto recorded = reader_.words();
    const auto [mine, theirs] = std::mismatch(words_.begin() + first, words_.end(), recorded.begin() + first);
    if (mine == words_.end() && record_.state_hash == row.state_hash) return;
    std::array<char, 100> values{};
    if (mine != words_.end()) {
      const std::string name =
          output_name(reader_.head().sizes, bodies_, static_cast<std::size_t>(mine - words_.begin()));
      std::snprintf(values.data(), values.size(), " is %.17g in the recording, %.17g in the replay",
                    std::bit_cast<double>(*theirs), std::bit_cast<double>(*mine));
      show_difference(row.cycle, row.t, name + values.data());
    } else {
      show_difference(row.cycle, row.t,
                      "the state hash is " + hash_text(row.state_hash) + " in the recording, " +
                          hash_text(record_.state_hash) + " in the replay; all outputs are equal");
    }
  }

  void show_difference(std::uint64_t cycle, double t, const std::string& text) {
    std::printf("first difference in cycle %llu, t = %.9g s: %s\n", static_cast<unsigned long long>(cycle), t,
                text.c_str());
    has_ended_ = failed_ = differs_ = true;
  }

  /// Returns the end of the last line.
  std::string outcome() {
    if (!compares_) return "; another scene is not compared";
    if (differs_) return "";
    if (!rig_ || !rig_->has_events()) return ", identical";
    const std::optional<std::uint64_t> missing = rig_->first_missing();
    if (!missing) return ", identical, also the rig";
    note(rig_->begins_later() ? "has the inputs of the rig from its middle on, so the rig is not repeated"
                              : "lacks inputs of the rig after cycle " + std::to_string(*missing - 1));
    failed_ = failed_ || !rig_->begins_later();
    return ", identical";
  }

  ExitCode end() {
    if (!has_state_ && last_ > now_) tell_gap(last_);
    if (reader_.lost_rows() > 0)
      note("lacks " + std::to_string(reader_.lost_rows()) + " rows, which were lost while it was written");
    if (reader_.damaged_bytes() > 0) {
      note("has " + std::to_string(reader_.damaged_bytes()) + " damaged bytes");
      failed_ = true;
    }
    std::printf("replayed %llu cycles", static_cast<unsigned long long>(num_cycles_));
    if (num_cycles_ > 0) std::printf(", t = %.9g to %.9g s", first_t_, last_t_);
    std::printf("%s\n", outcome().c_str());
    return failed_ ? ExitCode::fault : ExitCode::ok;
  }

  const ReplayOptions& options_;
  const SceneConfig& scene_;
  InputLogReader& reader_;
  std::unique_ptr<Engine> engine_;
  RunFiles* files_;
  std::vector<std::string> bodies_;
  std::vector<std::size_t> driven_;
  JointCoordinatesOf joints_;
  bool compares_;  // false for another scene
  std::optional<RigReplay> rig_;
  std::vector<std::uint64_t> words_;
  CycleRecord record_;
  std::uint64_t now_ = 0, last_ = 0;  // cycle of the engine, and of the latest row
  std::uint64_t begin_ = 0;           // cycle of the state with which the engine begins
  std::uint64_t num_cycles_ = 0;
  double first_t_ = 0, last_t_ = 0;
  bool has_state_ = true;  // true if the engine has the state after cycle now_
  bool has_ended_ = false, failed_ = false, differs_ = false;
};

void show_errors(const std::vector<std::string>& errors) {
  for (const std::string& error : errors) std::fprintf(stderr, "%s\n", error.c_str());
}

/// Returns an error if an output would overwrite a file that is read; empty otherwise.
std::string why_no_outputs(const ReplayOptions& options) {
  for (const std::string& out : {options.files.trace, options.files.contacts, options.files.nets})
    for (const std::string& in : {options.file, options.scene}) {
      std::error_code ignored;
      if (!out.empty() && std::filesystem::equivalent(out, in, ignored))
        return "'" + out + "' is also read: give another name";
    }
  return "";
}

ExitCode replay(const ReplayOptions& options) {
  if (const std::string why_not = why_no_outputs(options); !why_not.empty()) {
    show_errors({why_not});
    return ExitCode::usage;
  }
  const MappedFile file(options.file);
  const std::string name = printable(options.file);
  if (!file.why_not().empty()) {
    show_errors({name + " cannot be read: " + file.why_not()});
    return ExitCode::usage;
  }
  InputLogReader reader(file.bytes());
  if (!reader.why_not().empty()) {
    show_errors({name + " " + reader.why_not()});
    return ExitCode::usage;
  }
  const InputLogHead& head = reader.head();
  if (!is_of_this_build(head))
    std::fprintf(stderr, "note: %s was recorded by version %s, and this is %s: results may differ\n",
                 name.c_str(), build_of(head).c_str(), build_of(this_build()).c_str());
  LoadResult recorded = parse_scene_of(head, options.faults);
  if (!recorded.scene) {
    show_errors({name + ": its scene cannot be read:"});
    show_errors(recorded.errors);
    return ExitCode::usage;
  }
  if (recorded.scene->bodies.size() != head.sizes.bodies ||
      driven_bodies(*recorded.scene).size() < head.sizes.targets) {
    show_errors({name + ": its scene has other bodies than its rows: it is damaged"});
    return ExitCode::usage;
  }
  SceneConfig scene = *recorded.scene;
  if (!options.scene.empty()) {
    LoadResult other = load_scene(options.scene, options.faults);
    if (!other.scene) {
      show_errors(other.errors);
      return ExitCode::usage;
    }
    if (const std::string why_not = why_no_inputs_of(*recorded.scene, *other.scene); !why_not.empty()) {
      show_errors({"--scene: '" + options.scene + "' cannot have the inputs of " + name + ": " + why_not});
      return ExitCode::usage;
    }
    scene = *std::move(other.scene);
  }
  std::string why_not;
  std::unique_ptr<Engine> engine = make_engine(scene, reader.start().samples, why_not);
  if (!engine) {
    show_errors({name + ": " + why_not});
    return ExitCode::usage;
  }
  std::optional<RunFiles> files;
  const bool has_trace = !options.files.trace.empty() || options.files.trace_rows;
  if (has_trace || !options.files.contacts.empty() || !options.files.nets.empty())
    files.emplace(options.files, scene, head.log_origin_ns);
  const ExitCode code = Replay(options, scene, reader, std::move(engine), files ? &*files : nullptr).run();
  bool is_complete = true;
  if (files)
    for (const FileLoss& loss : files->close()) {
      show_errors({loss.path + " could not be written in full: " + loss.why});
      is_complete = false;
    }
  return is_complete ? code : std::max(code, ExitCode::fault);
}

}  // namespace

ExitCode replay_input_log(const std::string& file, const FaultChecks& checks,
                          std::function<bool(std::string_view)> rows) {
  ReplayOptions options;
  options.file = file;
  options.files.trace_rows = std::move(rows);
  options.faults = checks;
  return replay(options);
}

void add_replay(CLI::App& app, const FaultChecks& checks, ExitCode& code) {
  CLI::App* verb =
      app.add_subcommand("replay", "Repeat a recorded run bit for bit, and name the first difference.");
  const auto options = std::make_shared<ReplayOptions>();
  options->faults = checks;
  verb->add_option("FILE", options->file, "read this input log, of run --record FILE.godo or --on-fault")
      ->required();
  verb->add_option("--scene", options->scene,
                   "use this scene with the recorded inputs, without comparing; its bodies and its device "
                   "must be those of the recording")
      ->type_name("SCENE");
  verb->add_option(
          "--from", options->from,
          "begin at this time, s: the core is repeated from the last recorded state before it, the rig "
          "from its start")
      ->check(number_in(0, 1e9));
  verb->add_option("--to", options->to, "end after this time, s")->check(number_in(0, 1e9));
  verb->add_option("--trace", options->files.trace, "write a trace as run does")->type_name("FILE");
  verb->add_option("--contacts", options->files.contacts, "write every contact as run does")
      ->type_name("FILE");
  verb->add_option("--nets", options->files.nets, "write the nodes of nets as run does")->type_name("FILE");
  verb->callback([options, &code] { code = replay(*options); });
}

}  // namespace godobject
