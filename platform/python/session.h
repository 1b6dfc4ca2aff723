// A scene and its session in Python. The interpreter's lock is released while steps are taken; no Python code
// runs per step.
#pragma once

#include <pybind11/pybind11.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "hal/rig/bus_load.h"
#include "platform/python/dict.h"
#include "platform/python/errors.h"
#include "platform/python/quantities.h"
#include "platform/rig/buses.h"
#include "platform/simulated/session.h"

namespace godobject {

inline constexpr std::uint64_t steps_between_signals = 4096;  // steps between two checks for Ctrl-C

/// States over time: of each quantity the numbers of one state after those of the other.
struct Rows {
  std::uint64_t every = 0;  // 0: none is kept
  Numbers t{}, energy{}, joint_q{};
  std::array<Numbers, body_quantities.size()> of{};
};

class PySession {
 public:
  /// path: of the scene file, or name of the parts in errors. parts: the scene as a dict; none: that of the
  /// file. plain: as in toml_of_dict(). bus: "sim", "direct", or empty for that of `godobject run`.
  PySession(const std::string& path, const std::optional<py::dict>& parts, const py::function& plain,
            const std::string& bus, bool raises_faults)
      : raises_faults_(raises_faults) {
    LoadResult loaded = parts ? of_parts(*parts, path, plain) : load_scene(path, simulated_faults());
    refuse("SceneError", path, loaded.errors, std::move(loaded.placed_errors));
    warnings_ = std::move(loaded.placed_warnings);
    scene_ = *std::move(loaded.scene);
    const bool has_rig = scene_.device && scene_.device->rig;
    const bool has_device = has_rig || (scene_.device && !scene_.device->trackers.empty());
    bus_ = bus == "direct" || (bus.empty() && !has_device) ? BusChoice::direct : BusChoice::sim;
    std::vector<std::string> errors;
    if (bus_ == BusChoice::sim && !has_device)
      errors.emplace_back("the scene's device has no buses or trackers to simulate: use bus='direct'");
    if (has_rig) profiles_ = checked_profiles(scene_, path, errors);
    if (has_rig && bus_ == BusChoice::sim && errors.empty())
      for (const BusLoad& load : bus_load(*scene_.device->rig, scene_.step, usual_load(*scene_.device->rig)))
        if (is_overloaded(load)) errors.push_back(load_advice(load));
    refuse("SceneError", path, errors);
    for (std::string& warning : start(Motion(scene_), "SceneError", path))
      warnings_.push_back({.file = path, .at = {}, .text = std::move(warning)});
  }

  /// Starts again at t = 0. motion: table as text; none: that of the file. file: its path, or the name of the
  /// text; empty: the scene's own motion. Returns advice on the motion.
  std::vector<std::string> reset(const std::optional<std::string>& motion, const std::string& file) {
    require_idle();
    if (file.empty()) {
      session_
          .reset();  // its memory, still in the cache, serves the next one; this motion was accepted before
      static_cast<void>(start(Motion(scene_), "SceneError", scene_.name));
      return {};
    }
    MotionResult read = motion ? Motion::parse(*motion, file, scene_) : Motion::read(file, scene_);
    refuse("MotionError", file, read.errors, std::move(read.placed_errors));
    append(read.notes, start(*std::move(read.motion), "MotionError", file));
    return std::move(read.notes);
  }

  /// Takes n steps. Raises the faults that begin, after the step. every: keeps every n-th state; 0: none.
  py::dict step(std::uint64_t n, std::uint64_t every) {
    require_idle();
    Rows rows{.every = every};
    if (every > 0) keep(rows);
    begun_.clear();
    for (std::uint64_t left = n; left > 0 && begun_.empty();) {
      const std::uint64_t some = std::min(left, steps_between_signals);
      if (advance(some, rows) < some && begun_.empty())
        throw std::runtime_error("the device did not come up: reset() starts the session again");
      left -= some;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
    if (!begun_.empty()) raise_fault(record_.t, begun_);
    return to_python(std::move(rows));
  }

  /// Returns the number of steps of a run. duration: s; none: to the end of the motion.
  std::uint64_t num_steps(std::optional<double> duration) const {
    const double s = duration.value_or(end_.value_or(scene_.duration));
    if (!(s > 0 && s <= 1e6)) throw py::value_error("duration must be above 0 and at most 1e6 s");
    return static_cast<std::uint64_t>(std::max(1LL, std::llround(s / scene_.step)));
  }

  /// Returns the contacts that bear a force as views and names, as in the file of `run --contacts`.
  /// self: this session in Python.
  py::dict contacts(const py::object& self) const {
    std::vector<std::string> body, on;
    for (std::size_t i = 0; i < num_touching_; ++i) {
      const ContactView& c = touching_[i];
      body.push_back(c.is_node ? node_names_[c.a] : scene_.bodies[c.a].name);
      on.push_back(c.is_on_net    ? node_names_[c.b]
                   : c.b == world ? surface_names_[c.surface]
                                  : scene_.bodies[c.b].name);
    }
    const Shape shape{length(num_touching_), 3};
    py::dict all;
    for (std::size_t k = 0; k < contact_quantities.size(); ++k)
      all[contact_quantities[k].name] = view(contact_numbers_.of(k), shape, self);
    all["body"] = body;
    all["on"] = on;
    return all;
  }

  std::string state_hash() const {
    require_idle();
    std::array<char, 17> text{};
    std::snprintf(text.data(), text.size(), "%016" PRIx64, session_->engine().state_hash());
    return text.data();
  }

  const SceneConfig& scene() const { return scene_; }
  /// State after the last call.
  const CycleRecord& shown() const { return shown_; }
  const Numbers& body_numbers(std::size_t quantity) const { return body_numbers_[quantity]; }
  const Numbers& joint_numbers() const { return shown_.joint_q; }
  const Numbers& net_nodes() const { return net_nodes_; }
  /// First time of each fault since the start, s.
  const std::map<std::string, double>& faults() const { return shown_faults_; }
  /// Number of steps since the start in which each limit was active, as in the report of a run.
  std::map<std::string, std::uint64_t> limits() const {
    std::map<std::string, std::uint64_t> steps;
    for (std::size_t i = 0; i < run_limits.size(); ++i)
      if (shown_limits_[i] > 0) steps.emplace(run_limits[i].name, shown_limits_[i]);
    return steps;
  }
  py::list warnings() const { return problems(warnings_); }

 private:
  /// Reads the scene from its tables. Errors and warnings need the lines of its text.
  static LoadResult of_parts(const py::dict& parts, const std::string& path, const py::function& plain) {
    const FaultChecks checks = simulated_faults();
    if (const std::optional<toml::table> table = table_of_dict(parts, plain)) {
      LoadResult loaded = read_scene(*table, path, checks);
      if (loaded.scene && loaded.warnings.empty()) return loaded;
    }
    return parse_scene(toml_of_dict(parts, path, plain), path, checks);
  }

  void require_idle() const {
    if (stepping_) throw std::runtime_error("the scene is stepping in another thread: wait for it");
    if (!session_) throw std::runtime_error("the scene could not be started again: make another one");
  }

  /// Starts a session. Returns advice on its start. exception: for errors, about this file.
  std::vector<std::string> start(Motion motion, const char* exception, const std::string& file) {
    const std::optional<double> end = motion.end();
    Session::Made made = make_session(scene_, std::move(motion), bus_, profiles_);
    refuse(exception, file, made.errors);
    StartCheck check = check_start(*made.session);
    refuse(exception, file, check.errors);
    session_ = std::move(made.session);
    end_ = end;
    first_.clear();
    limit_steps_ = {};
    limited_ = Limited::none;
    active_limits_ = 0;
    present_ = 0;
    record_ = session_->at_start();
    const Engine& engine = session_->engine();
    touching_.resize(engine.composition().all_contacts());
    contact_numbers_.reserve(touching_.size());
    nodes_.resize(engine.nets().nodes.size());
    name_surfaces_and_nodes(engine.nets());
    if (!session_->boot(usual_boot_limit_s)) raise_not_ready();
    show();
    return std::move(check.warnings);
  }

  void name_surfaces_and_nodes(const SceneNets& nets) {
    surface_names_.clear();
    node_names_.clear();
    for (const ObstacleConfig& obstacle : scene_.obstacles)
      surface_names_.insert(surface_names_.end(), num_solids(obstacle), obstacle.name);
    for (const NetRange& net : nets.nets) node_names_.insert(node_names_.end(), net.num_nodes, net.name);
  }

  [[noreturn]] void raise_not_ready() const {
    const std::string rig = session_->rig() ? session_->rig()->fault_text() : "";
    FaultText text = text_of(session_->rig() ? RunFault::not_ready : RunFault::tracker_not_ready);
    if (!rig.empty()) text.meaning = rig;
    raise_fault(0, {text});
  }

  /// Takes steps without the interpreter's lock, up to one in which a fault is to be raised; shows the last.
  /// Returns their number.
  std::uint64_t advance(std::uint64_t n, Rows& rows) {
    std::uint64_t taken = 0;
    stepping_ = true;
    {
      const py::gil_scoped_release released;
      for (; taken < n && begun_.empty() && session_->advance(record_); ++taken) {
        note_limits();
        note_faults();
        if (rows.every > 0 && record_.cycle % rows.every == 0) keep(rows);
      }
    }
    stepping_ = false;
    show();
    return taken;
  }

  /// Counts the active limits, which are those of the step before if a scene without drives has equal bits.
  void note_limits() {
    if (session_->rig() || record_.limited != limited_) active_limits_ = active_limits(record_);
    limited_ = record_.limited;
    for (std::uint32_t active = active_limits_; active != 0; active &= active - 1)
      ++limit_steps_[static_cast<std::size_t>(std::countr_zero(active))];
  }

  void note_faults() {
    FaultBits now = static_cast<std::uint32_t>(record_.fault);
    now |= FaultBits{static_cast<std::uint32_t>(record_.rig_faults)} << 32;
    if (session_->truth() && !session_->truth()->reachable()) now |= unreachable_bit;
    if (record_.force_oscillates && !session_->rig()) now |= oscillates_bit;
    const FaultBits begun = now & ~present_;
    present_ = now;
    if (begun == 0) return;
    for (const auto& [bit, text] : fault_texts()) {
      if ((begun & bit) == 0) continue;
      first_.emplace(text.name, record_.t);
      if (raises_faults_) begun_.push_back(text);
    }
  }

  /// Writes the state into the memory of the views.
  void show() {
    shown_ = record_;
    shown_faults_ = first_;
    shown_limits_ = limit_steps_;
    for (std::size_t k = 0; k < body_quantities.size(); ++k) {
      body_numbers_[k].clear();
      add_bodies(record_, k, body_numbers_[k]);
    }
    num_touching_ = session_->engine().contacts(touching_);
    contact_numbers_.show(std::span(touching_).first(num_touching_));
    session_->engine().net_nodes(nodes_);
    net_nodes_.resize(3 * nodes_.size());
    for (std::size_t i = 0; i < nodes_.size(); ++i) write(nodes_[i], &net_nodes_[3 * i]);
  }

  static void add_bodies(const CycleRecord& record, std::size_t quantity, Numbers& to) {
    const BodyQuantity& of = body_quantities[quantity];
    for (const BodyView& body : record.bodies) {
      to.resize(to.size() + of.width);
      of.write(body, to.data() + to.size() - of.width);
    }
  }

  void keep(Rows& rows) const {
    rows.t.push_back(record_.t);
    rows.energy.push_back(record_.energy.total);
    rows.joint_q.insert(rows.joint_q.end(), record_.joint_q.begin(), record_.joint_q.end());
    for (std::size_t k = 0; k < rows.of.size(); ++k) add_bodies(record_, k, rows.of[k]);
  }

  py::dict to_python(Rows rows) const {
    py::dict all;
    if (rows.every == 0) return all;
    const py::ssize_t n = length(rows.t.size());
    all["t"] = array_of(std::move(rows.t), {n});
    all["energy"] = array_of(std::move(rows.energy), {n});
    all["joint_coordinates"] = array_of(std::move(rows.joint_q), {n, length(record_.joint_q.size())});
    for (std::size_t k = 0; k < rows.of.size(); ++k)
      all[body_quantities[k].name] = array_of(
          std::move(rows.of[k]), {n, length(scene_.bodies.size()), length(body_quantities[k].width)});
    return all;
  }

  bool raises_faults_;
  SceneConfig scene_;
  RigProfiles profiles_;
  BusChoice bus_ = BusChoice::direct;
  std::vector<PlacedText> warnings_;
  std::optional<double> end_;  // of the motion, s
  std::unique_ptr<Session> session_;
  CycleRecord record_, shown_;
  std::array<Numbers, body_quantities.size()> body_numbers_;
  std::vector<ContactView> touching_;
  std::size_t num_touching_ = 0;
  ContactNumbers contact_numbers_;
  std::vector<Vec3> nodes_;
  Numbers net_nodes_;
  std::vector<std::string> surface_names_, node_names_;
  FaultBits present_ = 0;
  std::vector<FaultText> begun_;  // faults to raise
  std::map<std::string, double> first_, shown_faults_;
  Limited limited_ = Limited::none;
  std::uint32_t active_limits_ = 0;
  std::array<std::uint64_t, run_limits.size()> limit_steps_{}, shown_limits_{};
  bool stepping_ = false;  // true while the steps are taken; guarded by the interpreter's lock
};

}  // namespace godobject
