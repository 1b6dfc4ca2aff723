// godobject export: writes a trace, a recording of buses or an input log in other formats.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>
#include <utility>

#include <CLI/CLI.hpp>

#include "hal/can/candump.h"
#include "platform/cli/command_line.h"
#include "platform/cli/program.h"
#include "platform/scene/toml.h"
#include "platform/trace/hdf5.h"
#include "platform/trace/input_log.h"
#include "platform/view/recorded/mcap.h"
#include "platform/view/recorded/recording.h"

namespace godobject {
namespace {

namespace fs = std::filesystem;

constexpr const char* export_about =
    "FILE is a trace of run --trace, a log of buses of run --record, or an input log (.godo), which is "
    "replayed and compared for it. A file that was cut is exported up to the cut, with a note. Frames of a "
    "log become lines or messages; with --scene the log is replayed, and the rows of its trace are "
    "exported. MCAP has a channel for each body, joint, drive and bus, and /tf with the poses; its times are "
    "t_bus where the trace has it, or else t. Numbers that are not finite are omitted there. HDF5 has a data "
    "set for each column.";

struct ExportOptions {
  std::string file, scene;
  std::string csv, candump, mcap, hdf5;  // files to write; empty: none
  std::size_t every = 1;                 // export every n-th row
  bool force = false;                    // true if an output may replace a file
  FaultChecks faults{};
};

std::string error_text(int number) { return std::generic_category().message(number); }

/// A file that appears under its name when it is complete.
class OutputFile {
 public:
  OutputFile(std::string option, std::string path) : option_(std::move(option)), path_(std::move(path)) {}
  ~OutputFile() {
    if (stream_.is_open() || is_begun_) {
      stream_.close();
      std::error_code ignored;
      fs::remove(part(), ignored);
    }
  }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  bool is_wanted() const noexcept { return !path_.empty(); }
  std::string part() const { return path_ + ".part"; }

  /// Returns why the file cannot be written; empty if it can. inputs: files that are read.
  std::string why_not(bool force, std::initializer_list<std::string> inputs) const {
    if (!is_wanted()) return "";
    std::error_code error;
    for (const std::string& input : inputs)
      if (fs::equivalent(path_, input, error)) return named() + " is also read: give another name";
    const fs::file_status status = fs::status(path_, error);
    if (fs::exists(status) && !fs::is_regular_file(status)) return named() + " is no regular file";
    if (fs::exists(status) && !force) return named() + " exists: give another name, or --force";
    if (fs::exists(fs::symlink_status(part(), error)))
      return named() + ": '" + part() + "' is left of another export: remove it";
    return "";
  }
  /// Marks that the part exists or is about to be created.
  void begin() noexcept { is_begun_ = true; }
  /// Opens the part for write().
  std::string open() {
    begin();
    stream_.open(part(), std::ios::binary);
    return stream_ ? "" : named() + " cannot be written: " + error_text(errno);
  }
  bool write(std::string_view bytes) {
    return static_cast<bool>(stream_.write(bytes.data(), static_cast<std::streamsize>(bytes.size())));
  }
  /// Renames the complete part to its final name. Returns empty or the error.
  std::string finish(bool is_complete, bool force) {
    if (stream_.is_open()) stream_.close();
    if (!is_complete || stream_.fail())
      return named() + " could not be written in full: the disk may be full";
    if (!force && renameat2(AT_FDCWD, part().c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE) != 0 &&
        errno == EEXIST)
      return named() + " exists now: give another name, or --force";
    std::error_code error;
    if (fs::exists(part(), error))
      fs::rename(part(), path_, error);  // with --force, or on a file system without RENAME_NOREPLACE
    is_begun_ = static_cast<bool>(error);
    return error ? named() + " cannot be written: " + error.message() : "";
  }

 private:
  std::string named() const { return option_ + ": '" + printable(path_) + "'"; }

  std::string option_, path_;
  std::ofstream stream_;
  bool is_begun_ = false;  // true if the part may exist
};

/// Destinations of rows or frames. Opens the requested files only.
class Outputs {
 public:
  explicit Outputs(const ExportOptions& options)
      : options_(options),
        csv_("--csv", options.csv),
        candump_("--candump", options.candump),
        mcap_("--mcap", options.mcap),
        hdf5_("--hdf5", options.hdf5) {}

  /// Returns why a file cannot be written; empty if all can.
  std::string why_not() const {
    for (const OutputFile* file : {&csv_, &candump_, &mcap_, &hdf5_})
      if (std::string why = file->why_not(options_.force, {options_.file, options_.scene}); !why.empty())
        return why;
    return "";
  }

  // Each of the following functions returns empty or an error.

  std::string begin_rows(const std::vector<std::string>& names) {
    if (names.size() < 2 || names.front() != "t")
      return options_.file + ": is no trace, whose first column is t, and no other recording";
    if (names.size() > McapWriter::max_channels) return options_.file + ": has too many columns";
    numbers_.resize(names.size());
    if (std::string why = open(); !why.empty()) return why;
    std::string header;
    for (const std::string& name : names) header += (header.empty() ? "" : ",") + name;
    write(csv_, header + "\n");
    if (mcap_.is_wanted()) rows_.emplace(to_mcap(), library, names);
    if (!hdf5_.is_wanted()) return "";
    hdf5_.begin();
    const std::string why =
        hdf5_rows_.open(hdf5_.part(), names,
                        std::string(library) + ", export of " + options_.file + "; SI units, world frame");
    return why.empty() ? "" : "--hdf5: " + why;
  }

  std::string add_row(const std::string& line) {
    constexpr double max_time = 9e9;  // s, below the largest number of nanoseconds
    if (!read_numbers(line, numbers_))
      return "not the " + std::to_string(numbers_.size()) + " numbers of a row";
    if (!(numbers_.front() >= 0 && numbers_.front() <= max_time)) return "its time is not in [0, 9e9] s";
    if (num_read_++ % options_.every != 0) return "";
    write(csv_, line + "\n");
    if (rows_) rows_->add(numbers_);
    if (hdf5_.is_wanted()) hdf5_rows_.add(numbers_);
    return "";
  }

  std::string begin_frames() {
    if (std::string why = open(); !why.empty()) return why;
    write(csv_, "t,bus,id,extended,remote,fd,bit_rate_switch,size,data\n");
    if (mcap_.is_wanted()) frames_.emplace(to_mcap(), library);
    return "";
  }

  /// line: the frame in candump's format. bus: name of its bus.
  void add_frame(const std::string& line, const ReceivedFrame& received, std::string_view bus) {
    if (num_read_++ % options_.every != 0) return;
    write(candump_, line + "\n");
    if (csv_.is_wanted()) write(csv_, row_of(received, bus));
    if (frames_) frames_->add(received, bus);
  }

  /// Number of rows or frames that were read.
  std::size_t num_read() const noexcept { return num_read_; }

  /// Completes the files, and prints their names. Returns the errors.
  std::vector<std::string> finish() {
    std::vector<std::string> errors;
    if (rows_) all_taken_ = rows_->close() && all_taken_;
    if (frames_) all_taken_ = frames_->close() && all_taken_;
    all_taken_ = hdf5_rows_.close() && all_taken_;
    for (OutputFile* file : {&csv_, &candump_, &mcap_, &hdf5_}) {
      if (!file->is_wanted()) continue;
      if (std::string why = file->finish(all_taken_, options_.force); !why.empty()) errors.push_back(why);
    }
    return errors;
  }

 private:
  static constexpr const char* library = "godobject " GODOBJECT_VERSION;

  std::string open() {
    for (OutputFile* file : {&csv_, &candump_, &mcap_})
      if (std::string why = file->is_wanted() ? file->open() : ""; !why.empty()) return why;
    return "";
  }
  void write(OutputFile& file, const std::string& text) {
    if (file.is_wanted()) all_taken_ = file.write(text) && all_taken_;
  }
  McapWriter::Sink to_mcap() {
    return [this](std::string_view bytes) { return mcap_.write(bytes); };
  }
  static std::string row_of(const ReceivedFrame& received, std::string_view bus) {
    const CanFrame& frame = received.frame;
    std::array<char, 64> text{};
    constexpr long long second = 1'000'000'000;
    std::snprintf(text.data(), text.size(), "%lld.%09lld,", received.t_ns / second, received.t_ns % second);
    std::string row = text.data() + std::string(bus);
    std::snprintf(text.data(), text.size(), ",0x%x,%d,%d,%d,%d,%d,0x", frame.id, frame.extended, frame.remote,
                  frame.fd, frame.bit_rate_switch, frame.size);
    return row + text.data() + hex_of(frame.bytes()) + "\n";
  }

  const ExportOptions& options_;
  OutputFile csv_, candump_, mcap_, hdf5_;
  std::optional<McapRows> rows_{};
  std::optional<McapFrames> frames_{};
  Hdf5Writer hdf5_rows_{};
  std::vector<double> numbers_{};
  std::size_t num_read_ = 0;
  bool all_taken_ = true;
};

struct ReadResult {
  std::vector<std::string> errors{};
  bool is_cut = false;  // true if the last line has no end
  bool failed = false;  // true if errors were printed
};

ReadResult read_frames(const std::string& path, Outputs& outputs) {
  if (std::string why = outputs.begin_frames(); !why.empty()) return {.errors = {why}};
  std::ifstream in(path, std::ios::binary);
  std::size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (in.eof()) return {.is_cut = true};  // without a line end
    ReceivedFrame frame;
    std::string_view bus;
    const CandumpResult result = parse_candump(line, frame, bus);
    if (result == CandumpResult::ignored || result == CandumpResult::error_frame) continue;
    if (result != CandumpResult::ok)
      return {.errors = {path + ":" + std::to_string(number) + ": no frame in candump's format"}};
    outputs.add_frame(line, frame, bus);
  }
  return {};
}

/// Kind of a recording, by its first bytes.
enum class Kind : std::uint8_t { rows, frames, inputs };

ReadResult read_recording(const ExportOptions& options, Kind kind, Outputs& outputs) {
  const UseNames begin = [&](const std::vector<std::string>& names) { return outputs.begin_rows(names); };
  const UseRow add = [&](const std::string& line) { return outputs.add_row(line); };
  ReadResult result;
  if (kind == Kind::inputs) {
    std::string why;
    bool has_header = false;
    const auto use = [&](std::string_view text) {
      text.remove_suffix(1);  // the line's end
      if (why.empty())
        why = std::exchange(has_header, true) ? add(std::string(text)) : begin(split_at_commas(text));
      return why.empty();
    };
    result.failed = replay_input_log(options.file, options.faults, use) != ExitCode::ok;
    if (!why.empty()) result.errors.push_back(why);
  } else if (kind == Kind::rows) {
    if (std::string why = read_rows(options.file, begin, add, &result.is_cut); !why.empty())
      result.errors.push_back(why);
  } else if (options.scene.empty()) {
    result = read_frames(options.file, outputs);
  } else {
    const LoadResult loaded = load_scene(options.scene, options.faults);
    if (!loaded.scene || !loaded.errors.empty()) return {.errors = loaded.errors};
    RecordingResult replayed = replay_rows(options.file, options.scene, *loaded.scene, begin, add);
    for (const std::string& note : replayed.notes) std::fprintf(stderr, "note: %s\n", note.c_str());
    result.errors = std::move(replayed.errors);
  }
  return result;
}

/// Returns why the options do not suit the recording; empty if they do.
std::string why_not(const ExportOptions& options, Kind kind) {
  const bool has_rows = kind != Kind::frames || !options.scene.empty();
  if (options.csv.empty() && options.candump.empty() && options.mcap.empty() && options.hdf5.empty())
    return "name a file to write: --csv, --candump, --mcap or --hdf5";
  if (kind != Kind::frames && !options.scene.empty())
    return "--scene is for logs of buses; " + options.file + " has its own rows";
  if (has_rows && !options.candump.empty())
    return "--candump needs frames: give a log of buses of run --record, without --scene";
  if (!has_rows && !options.hdf5.empty()) return "--hdf5 needs rows: replay the log by --scene SCENE";
  return "";
}

ExitCode export_recording(const ExportOptions& options) {
  const auto fail = [](const std::vector<std::string>& errors, ExitCode code) {
    for (const std::string& error : errors) std::fprintf(stderr, "%s\n", error.c_str());
    return code;
  };
  std::array<char, 8> begin{};
  std::ifstream in(options.file, std::ios::binary);
  if (!in.read(begin.data(), begin.size()) && in.gcount() == 0)
    return fail({options.file + ": cannot be read, or is empty"}, ExitCode::usage);
  in.close();
  const bool is_inputs = std::string_view(begin.data(), 7) == input_log_magic.substr(0, 7);
  const Kind kind = is_inputs ? Kind::inputs : begin[0] == '(' ? Kind::frames : Kind::rows;
  if (std::string why = why_not(options, kind); !why.empty()) return fail({why}, ExitCode::usage);
  Outputs outputs(options);
  if (std::string why = outputs.why_not(); !why.empty()) return fail({why}, ExitCode::usage);
  const ReadResult read = read_recording(options, kind, outputs);
  const char* const items = kind == Kind::frames && options.scene.empty() ? "frames" : "rows";
  if (outputs.num_read() == 0)
    return fail(
        read.errors.empty() && !read.failed ? std::vector{options.file + ": has no " + items} : read.errors,
        ExitCode::usage);
  fail(read.errors, ExitCode::ok);
  if (read.is_cut)
    std::fprintf(stderr, "note: %s was cut, or is still written: the last line is not exported\n",
                 options.file.c_str());
  const std::vector<std::string> lost = outputs.finish();
  fail(lost, ExitCode::ok);
  if (lost.empty()) std::printf("exported %zu %s\n", outputs.num_read(), items);
  return lost.empty() && read.errors.empty() && !read.failed ? ExitCode::ok : ExitCode::fault;
}

}  // namespace

void add_export(CLI::App& app, const FaultChecks& checks, ExitCode& code) {
  CLI::App* verb = app.add_subcommand("export", "Write a trace or recording as CSV, candump, MCAP or HDF5.");
  verb->footer(export_about);
  const auto options = std::make_shared<ExportOptions>();
  options->faults = checks;
  verb->add_option("FILE", options->file, "read this trace, log of buses, or input log")->required();
  verb->add_option("--csv", options->csv, "write rows or frames as comma-separated values")
      ->type_name("FILE");
  verb->add_option("--candump", options->candump, "write frames as candump -l does")->type_name("FILE");
  verb->add_option("--mcap", options->mcap, "write messages for Foxglove, Lichtblick or PlotJuggler")
      ->type_name("FILE");
  verb->add_option("--hdf5", options->hdf5, "write rows as one data set for each column")->type_name("FILE");
  verb->add_option("--scene", options->scene, "replay a log of buses in this scene file (TOML)");
  verb->add_option("--every", options->every, "export every n-th row or frame")
      ->capture_default_str()
      ->check(number_in(1, 1e9));
  verb->add_flag("--force", options->force, "replace files that exist");
  verb->callback([options, &code] { code = export_recording(*options); });
}

}  // namespace godobject
