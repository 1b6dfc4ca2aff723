#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "tests/study/peer/section.h"
#include "tests/study/peer/work_precision.h"
#include "tests/study/report/text.h"

namespace godobject::study {
namespace {

constexpr double torn = 1;         // strain
constexpr double lost_bag = 0.03;  // m: error of a node, the radius of the bag

std::string scientific(double value) { return std::isfinite(value) ? number(value, 2) : "fails"; }

std::string us(const std::optional<double>& time) {
  if (!time) return "-";
  return *time < 100 ? number(*time, 2) : whole(time);
}

/// Returns the line under the header of a table with so many columns after the first.
std::string rule(std::size_t columns) {
  std::string line = "|---|";
  for (std::size_t i = 0; i < columns; ++i) line += "---|";
  return line + '\n';
}

/// A number of all engines of which less is better.
struct Measure {
  std::string name;
  std::vector<std::pair<std::string, double>> values;  // engine, value
};

/// Returns the least and the greatest stiffness of S2; the others are in the result file.
std::set<double> reported_stiffnesses(const PeerResults& results) {
  std::set<double> all;
  for (const PeerContact& r : results.contacts) all.insert(r.k);
  return all.empty() ? all : std::set<double>{*all.begin(), *all.rbegin()};
}

std::vector<Measure> measures_of(const PeerResults& results) {
  std::vector<Measure> all;
  const auto add = [&](const std::string& name, const std::string& engine, double value) {
    auto it = std::ranges::find(all, name, &Measure::name);
    if (it == all.end()) it = all.insert(it, {name, {}});
    it->values.emplace_back(engine, std::abs(value));
  };
  for (const PeerError& r : results.errors) {
    if (std::abs(r.h / compared_step - 1) > 1e-6) continue;
    add(r.scene + " position", r.engine, r.position);
    add(r.scene + " rotation", r.engine, r.rotation);
  }
  const std::set<double> stiffnesses = reported_stiffnesses(results);
  for (const PeerContact& r : results.contacts) {
    if (!stiffnesses.contains(r.k)) continue;
    add("S2 penetration at " + number(r.k) + " N/m", r.engine, r.depth);
    add("S2 jitter at " + number(r.k) + " N/m", r.engine, r.jitter);
  }
  for (const PeerPile& r : results.piles) add("S4 overlap", r.engine, r.overlap);
  for (const PeerNet& r : results.nets) add("S6 stretch", r.engine, r.stretch);
  for (const PeerBag& r : results.bags)
    add("bag depth", r.engine, r.error < lost_bag ? r.depth : std::numeric_limits<double>::infinity());
  return all;
}

/// Returns the measures in which a peer is better than the integrator, and how much. Empty if there is none.
std::string peers_better_than(const PeerResults& results, const char* integrator) {
  std::string text;
  for (const Measure& measure : measures_of(results)) {
    const std::pair<std::string, double>*own = nullptr, *peer = nullptr;
    for (const auto& value : measure.values) {
      if (is_ours(value.first) && !value.first.starts_with(integrator)) continue;
      auto& best = is_ours(value.first) ? own : peer;
      if (best == nullptr || value.second < best->second) best = &value;
    }
    if (own == nullptr || peer == nullptr || !(peer->second < noticeable * own->second)) continue;
    text += (text.empty() ? "" : "; ") + measure.name + " (" + peer->first + ": " + scientific(peer->second) +
            ", ours " + scientific(own->second) + ")";
  }
  return text;
}

void write_winners(std::ostream& out, const PeerResults& results) {
  std::string better;
  for (const char* integrator : {TrBdf2::name, ImplicitEuler::name}) {
    const std::string list = peers_better_than(results, integrator);
    if (!list.empty()) better += std::string("- than ") + integrator + ": " + list + ".\n";
  }
  const std::string in_equal_time = peers_better_in_equal_time(results);
  if (!in_equal_time.empty())
    better += "- in equal native time or to an equal error: " + in_equal_time + ".\n";
  if (better.empty()) out << "No peer is better than ours by 5 % at a step of 1 ms.\n";
  else out << "**A peer is better, by 5 % or more at a step of 1 ms:**\n\n" << better;
}

/// Returns the time of a step, that of an engine in WASM marked.
std::string time_cell(const std::optional<double>& native_us, const std::optional<double>& wasm_us) {
  if (native_us) return us(native_us);
  return wasm_us ? us(wasm_us) + " W" : "-";
}

void write_peer_errors(std::ostream& out, const PeerResults& results) {
  const std::vector<std::string> scenes = scenes_of(results);
  out << "\nWorst errors at 1 ms, and us of a step, that is ms of a simulated second. "
         "Times are native, of one run in interleaved rounds on "
      << results.machine << "; those with W are of WASM and not to be compared:\n\n| engine |";
  for (const std::string& scene : scenes) out << ' ' << scene << ", m | rad | us |";
  out << '\n' << rule(3 * scenes.size());
  for (const std::string& engine : engines_of(results)) {
    if (std::ranges::find(results.errors, engine, &PeerError::engine) == results.errors.end()) continue;
    out << "| " << engine << " |";
    for (const std::string& scene : scenes) {
      const PeerError* const r = find_row(results.errors, scene, engine, compared_step);
      if (r == nullptr) out << " - | - | - |";
      else
        out << ' ' << scientific(r->position) << " | " << scientific(r->rotation) << " | "
            << time_cell(r->native_us, r->us_per_step) << " |";
    }
    out << '\n';
  }
  out << "\n![errors beside other engines](figures/peers.png)\n";
}

void write_peer_contacts(std::ostream& out, const PeerResults& results) {
  if (results.contacts.empty()) return;
  const std::set<double> stiffnesses = reported_stiffnesses(results);
  out << "\nS2 at 1 ms, by the coupling's stiffness: mean penetration and its jitter, m, and us of a step. "
         "Ours is the scene's "
         "law of 2e5 N/m a sphere, or hard, 1e8 N/m:\n\n| engine |";
  for (const double k : stiffnesses) out << ' ' << number(k) << " N/m |";
  out << '\n' << rule(stiffnesses.size());
  for (const std::string& engine : engines_of(results)) {
    if (std::ranges::find(results.contacts, engine, &PeerContact::engine) == results.contacts.end()) continue;
    out << "| " << engine << " |";
    for (const double k : stiffnesses)
      for (const PeerContact& r : results.contacts)
        if (r.engine == engine && r.k == k)
          out << ' ' << (std::isfinite(r.depth) ? number(r.depth, 2) + ", " + number(r.jitter, 2) : "fails")
              << ", " << time_cell(r.native_us, r.us_per_step) << " |";
    out << '\n';
  }
}

void write_peer_many(std::ostream& out, const PeerResults& results) {
  if (results.piles.empty()) return;
  out << "\nS4 at 1 ms: overlap of bricks, largest and median; S6: error of the stretch at rest; median us "
         "of a "
         "step:\n\n| engine | S4, m | median | us |\n"
      << rule(3);
  for (const PeerPile& r : results.piles)
    out << "| " << r.engine << " | " << scientific(r.overlap) << " | " << scientific(r.median) << " | "
        << time_cell(r.native_us, r.us_per_step) << " |\n";
  out << "\n| engine | S6 | us |\n" << rule(2);
  for (const PeerNet& r : results.nets)
    out << "| " << r.engine << " | " << (r.stretch < torn ? scientific(r.stretch) : "fails") << " | "
        << time_cell(r.native_us, r.us_per_step) << " |\n";
}

void write_peer_bags(std::ostream& out, const PeerResults& results) {
  if (results.bags.empty()) return;
  out << "\nThe bag of `sim/scenes/endobag.toml` on anchors of the world, a bar of 12 mm pressed 20 mm "
         "towards "
         "it without friction, at rest: farthest node from the solution with complete iterations and hard "
         "contacts; deepest node in the bar; median us of a step. Ours is the scene's law of 200 N/m a node, "
         "or "
         "hard, 1e5 N/m. MuJoCo's package has no model of a bag; its nodes are on slides, its springs "
         "are tendons, its contacts have solref 0.002 1:\n\n| engine | bag, m | depth, m | us |\n"
      << rule(3);
  for (const PeerBag& r : results.bags)
    out << "| " << r.engine << " | " << (r.error < lost_bag ? scientific(r.error) : "fails") << " | "
        << (r.error < lost_bag ? scientific(r.depth) : "-") << " | " << time_cell(r.native_us, r.us_per_step)
        << " |\n";
}

void write_peer_stability(std::ostream& out, const PeerResults& results) {
  constexpr double lost = 0.01;  // m from the target, thirty times the lag at 1e3 N/m
  std::set<double> stiffnesses, steps;
  for (const PeerStability& r : results.stability) {
    stiffnesses.insert(r.k);
    steps.insert(r.h);
  }
  out << "\nS1 stiffened at equal damping ratio, 2 s: the longest step of";
  for (const double h : steps) out << (h == *steps.begin() ? " " : ", ") << number(1e3 * h);
  out << " ms that stays within 1 cm of the target, ms; engines not named stay with the longest:\n\n| engine "
         "|";
  for (const double k : stiffnesses) out << ' ' << number(k) << " N/m |";
  out << '\n' << rule(stiffnesses.size());
  for (const std::string& engine : engines_of(results)) {
    const auto leaves = [&](const PeerStability& r) { return r.engine == engine && !(r.distance < lost); };
    if (std::ranges::none_of(results.stability, leaves)) continue;
    out << "| " << engine << " |";
    for (const double k : stiffnesses) {
      double longest = 0;
      for (const PeerStability& r : results.stability)
        if (r.engine == engine && r.k == k && r.distance < lost) longest = std::max(longest, r.h);
      out << ' ' << (longest > 0 ? number(1e3 * longest) : "none") << " |";
    }
    out << '\n';
  }
}

constexpr const char* peers_method = R"(
Couplings. MuJoCo: springs and dampers on slides and a ball, the springs' reference moved; on S3 actuators to a mocap
body. The step's target is that of its start with Euler, implicit and implicitfast, its end with `discrete`, its middle
with RK4. ODE: dWorldStep, motor rows that make it implicit Euler. Bullet, Rapier, "Jolt forces": forces with implicit
denominators; "Jolt motors": six-axis motors to a kinematic target. Simbody evaluates the target at any instant; accuracy
of CPodes: (h / 1 s)^2. Bullet (double precision), Jolt and Rapier (single) receive the step's mean target velocity.
Contacts: MuJoCo's solref 0.02 0.5 was the calmest tried, in 2.2 0.02 1; Jolt's bricks are rounded by 0.5 mm. Sources:
tests/bench/peer, tests/bench/wasm; command: `./dev study --peers`.
)";

}  // namespace

void write_peers(std::ostream& out, const PeerResults& results) {
  out << "## Beside other engines\n\n";
  if (results.errors.empty()) {
    out << "Left out: " << results.why_not << ".\n\n";
    return;
  }
  write_winners(out, results);
  if (!results.why_not.empty()) out << "\nEngines in WASM are left out: " << results.why_not << ".\n";
  if (!results.missing.empty())
    out << "\nNative engines not found by the build: " << results.missing << ".\n";
  write_peer_errors(out, results);
  write_work(out, results);
  write_peer_contacts(out, results);
  write_peer_many(out, results);
  write_peer_bags(out, results);
  write_peer_stability(out, results);
  out << peers_method;
  if (!results.versions.empty()) out << "\nVersions: " << results.versions << ".\n";
  out << '\n';
}

void replace_peers(const std::filesystem::path& report, const PeerResults& results) {
  std::ifstream in(report);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t begin = text.find(peers_begin), end = text.find(peers_end);
  if (begin == std::string::npos || end == std::string::npos || end < begin)
    throw std::runtime_error(
        report.string() + ": has no lines " + peers_begin + "and " + peers_end +
        "between which the section on peers belongs: write the report with ./dev study first");
  std::ostringstream section;
  write_peers(section, results);
  std::ofstream out(report);
  out << text.substr(0, begin) << peers_begin << section.str() << text.substr(end);
  if (!out.flush()) throw std::runtime_error(report.string() + ": cannot be written");
}

}  // namespace godobject::study
