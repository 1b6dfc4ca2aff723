#include "tests/study/net/study.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "tests/core/net/small_net.h"
#include "tests/study/csv_writer.h"
#include "tests/study/net/tube.h"
#include "tests/study/plots.h"

namespace godobject::study {
namespace {

using Clock = std::chrono::steady_clock;

double nanoseconds(Clock::duration time) { return std::chrono::duration<double, std::nano>(time).count(); }

template <class I>
double time_small(double h, bool on_floor, int runs) {
  std::vector<double> times;
  for (int n = 0; n < runs; ++n) {
    const auto net = std::make_unique<small_net::NetSmall<I>>(h, on_floor);
    const Clock::time_point start = Clock::now();
    net->moved();
    times.push_back(nanoseconds(Clock::now() - start) * h / small_net::duration);
  }
  std::ranges::nth_element(times, times.begin() + runs / 2);
  return times[static_cast<std::size_t>(runs / 2)];
}

template <class I>
void add_errors(bool on_floor, const small_net::Truth& truth, bool quick, std::vector<NetErrorRow>& rows) {
  const NetErrorRow* coarser = nullptr;
  const std::vector<double> steps = error_steps(quick);
  rows.reserve(rows.size() + steps.size());
  for (const double h : steps) {
    NetErrorRow row{.scene = on_floor ? "pressed" : "free", .integrator = I::name, .h = h, .order = {}};
    row.position = small_net::error<I>(h, on_floor, false, truth);
    row.share = row.position / truth.deformation;
    if (coarser != nullptr) row.order = std::log2(coarser->position / row.position);
    row.ns_per_step = time_small<I>(h, on_floor, quick ? 3 : 31);
    rows.push_back(row);
    coarser = &rows.back();
  }
}

template <Scene S>
NetCostRow cost_of(std::uint32_t round, int presses) {
  TubeRun<S> tube(round);
  NetCostRow row{.integrator = S::Integrator::name,
                 .nodes = tube.num_nodes(),
                 .instructions = {},
                 .params_bytes = sizeof(Params<S>),
                 .state_bytes = sizeof(State<S>),
                 .scratch_bytes = sizeof(Scratch<S>)};
  std::vector<double> times;
  const double share = 1.0 / (presses * static_cast<double>(tube.num_pressed));
  for (int n = 0; n < presses; ++n) {
    tube.press();
    for (std::size_t i = 0; i < tube.num_pressed; ++i) {
      const Clock::time_point start = Clock::now();
      tube.step();
      times.push_back(nanoseconds(Clock::now() - start));
      row.iterations += share * tube.report().iterations;
      row.contacts += share * static_cast<double>(tube.report().num_contacts);
    }
  }
  std::ranges::sort(times);
  row.ns_per_step = times[times.size() / 2];
  row.ns_p99 = times[times.size() * 99 / 100];
  return row;
}

template <class I>
void add_costs(bool quick, InstructionCounter& counter, const Progress& progress,
               std::vector<NetCostRow>& rows) {
  for (const std::uint32_t round : {10, 18, 32}) {
    if (quick && round > 10) return;
    progress("nets: cost, " + std::string(I::name) + ", " + std::to_string(round * round) + " nodes");
    rows.push_back(cost_of<NetTool<I, 1024>>(round, quick ? 1 : 3));
    if (round == 32)
      rows.back().instructions = counter.per_step(std::string("net-tool-1024 ") + I::name, "s6");
  }
}

}  // namespace

NetResults study_nets(bool quick, InstructionCounter& counter, const Progress& progress) {
  NetResults results;
  for (const bool on_floor : {false, true}) {
    progress(on_floor ? "nets: error, pressed" : "nets: error, free");
    const small_net::Truth truth = small_net::solved_exactly(on_floor);
    (on_floor ? results.deformation_pressed : results.deformation_free) = truth.deformation;
    add_errors<ImplicitEuler>(on_floor, truth, quick, results.errors);
    add_errors<TrBdf2>(on_floor, truth, quick, results.errors);
  }
  add_costs<ImplicitEuler>(quick, counter, progress, results.costs);
  add_costs<TrBdf2>(quick, counter, progress, results.costs);
  return results;
}

void write_csv(const std::filesystem::path& file, const std::vector<NetErrorRow>& rows) {
  CsvWriter csv(
      file,
      "scene,integrator,step_s,position_error_m,share_of_deformation,order,ns_per_step,ns_per_simulated_s");
  for (const NetErrorRow& r : rows)
    csv.row(r.scene, r.integrator, r.h, r.position, r.share, r.order, r.ns_per_step, r.ns_per_step / r.h);
}

void write_csv(const std::filesystem::path& file, const std::vector<NetCostRow>& rows) {
  CsvWriter csv(file,
                "integrator,nodes,ns_per_step,ns_p99,iterations,contacts,instructions,params_bytes,state_"
                "bytes,scratch_bytes");
  for (const NetCostRow& r : rows)
    csv.row(r.integrator, r.nodes, r.ns_per_step, r.ns_p99, r.iterations, r.contacts, r.instructions,
            r.params_bytes, r.state_bytes, r.scratch_bytes);
}

void write_net_script(const std::filesystem::path& directory) {
  std::ofstream out = script(directory, "net-error", 720, 340);
  out << "set logscale xy\nset format xy '10^{%T}'\nset grid\nset key bottom left font 'sans,7'\n"
      << "set xlabel 'compute per simulated second, us'\nset ylabel 'worst position error, m'\nset multiplot "
         "layout 1,2\n";
  for (const std::string scene : {"free", "pressed"}) {
    out << "set title '" << scene << "'\nplot";
    const char* separator = " ";
    for (const auto& [integrator, colour] :
         {std::pair{ImplicitEuler::name, "purple"}, {TrBdf2::name, "forest-green"}}) {
      out << separator << "'net-error.csv' using (strcol('scene') eq '" << scene
          << "' && strcol('integrator') eq '" << integrator
          << "' ? column('ns_per_simulated_s')*1e-3 : NaN):(column('position_error_m')) with linespoints pt "
             "7 ps 0.6 lc rgb '"
          << colour << "' title '" << integrator << "'";
      separator = ", ";
    }
    out << '\n';
  }
  out << "unset multiplot\n";
}

}  // namespace godobject::study
