// Other engines beside the core on the same scenes: natively those of tests/bench/peer, in node those of
// tests/bench/wasm. Native times stem from one run in interleaved rounds; those of WASM are not comparable.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/study/error_study.h"

namespace godobject::study {

inline constexpr double compared_step = 1e-3;  // s, of the report's tables
inline constexpr double noticeable = 0.95;     // of our value, from which on a peer is better

/// Error of an engine on a scene with a reference; infinite if it failed.
struct PeerError {
  std::string scene, engine;
  double h = 0;                          // s
  double position = 0;                   // m
  double rotation = 0;                   // rad
  std::optional<double> us_per_step;     // in WASM; absent for native engines
  std::optional<double> native_us = {};  // of a step; absent in WASM
};

/// S2, the tool pressed into a plane and dragged, at 1 ms.
struct PeerContact {
  std::string engine;
  double k = 0;       // N/m, of the coupling
  double depth = 0;   // m: mean penetration after 3 s; infinite if the engine failed
  double jitter = 0;  // m: rms of its change from step to step
  std::optional<double> us_per_step;
  std::optional<double> native_us = {};
};

/// S4, a brick dragged through a pile of 63, 20 s at 1 ms.
struct PeerPile {
  std::string engine;
  double overlap = 0;  // m: of the two deepest bricks, largest of 200 instants; infinite if it failed
  double median = 0;   // m
  std::optional<double> us_per_step, p99_us;
  std::optional<double> native_us = {}, native_p99_us = {};
};

/// S6, the hanging net of tests/bench/net_contest.h after 1 s, without its ball.
struct PeerNet {
  std::string engine;
  double stretch = 0;  // largest difference of a hanging spring's strain from that at rest
  std::optional<double> us_per_step;
  std::optional<double> native_us = {};
};

/// The bag of endobag.toml with a bar pressed into it, at rest after 2 s at 1 ms.
struct PeerBag {
  std::string engine;
  double error = 0;  // m: of the farthest node from bag_at_rest(); infinite if the engine failed
  double depth = 0;  // m: of the deepest node in the bar
  std::optional<double> us_per_step;
  std::optional<double> native_us = {};
};

/// S1 with its springs stiffened at equal damping ratio, 2 s.
struct PeerStability {
  std::string engine;
  double k = 0;         // N/m
  double h = 0;         // s
  double distance = 0;  // m: largest from the target; infinite if the engine failed
};

struct PeerResults {
  std::vector<PeerError> errors;
  std::vector<PeerContact> contacts;
  std::vector<PeerPile> piles;
  std::vector<PeerNet> nets;
  std::vector<PeerBag> bags;
  std::vector<PeerStability> stability;
  std::string versions;  // of the packages
  std::string why_not;   // reason that no peer ran in node; empty if they ran
  std::string missing;   // native engines that the build has not found; empty if none
  std::string machine;   // processor, and its load when the times were measured
};

struct PeerFolders {
  std::filesystem::path out;       // receives scene files and peers.json; made if absent
  std::filesystem::path packages;  // with node_modules; empty: that of ./dev setup peers
};

/// Runs the core, the native peers of the build and, if node and the packages are installed, those in WASM.
/// quick: S1 alone, for a second.
PeerResults study_peers(const PeerFolders& folders, bool quick, const Progress& progress);

/// Returns the source of the program for node.
std::filesystem::path peer_program();

/// True for one of the core's integrators.
bool is_ours(const std::string& engine);

/// Returns the row of a scene, engine and step; null if there is none.
const PeerError* find_row(const std::vector<PeerError>& rows, const std::string& scene,
                          const std::string& engine, double h);

/// Returns the engines, the core's integrators first, and the scenes with a reference.
std::vector<std::string> engines_of(const PeerResults& results);
std::vector<std::string> scenes_of(const PeerResults& results);

/// Writes peers-error.csv, peers-contact.csv, peers-pile.csv, peers-net.csv, peers-bag.csv,
/// peers-stability.csv and peers-work.csv.
void write_csv(const std::filesystem::path& out, const PeerResults& results);

void write_peer_script(const std::filesystem::path& out, const PeerResults& results);

}  // namespace godobject::study
