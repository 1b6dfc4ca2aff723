#include "tests/study/feel/table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace godobject::study {
namespace {

constexpr std::array decades_Hz{0.1, 1.0, 10.0, 100.0};
constexpr const char* shown_integrator = "tr-bdf2";
constexpr double shown_ratio = 1.4;

/// Returns a cell with this number.
std::string cell(const char* format, double value) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data() + std::string(" |");
}

/// Returns "| plan | count |".
std::string head_of(const FeelPlan& plan) {
  return "| " + plan.name + " |" + (plan.has_buses ? cell(" %g", 1e6 * plan.count_m) : " - |");
}

const Felt& at(const FeelSweep& sweep, double f_Hz) {
  return *std::ranges::min_element(sweep.felt, {},
                                   [&](const Felt& felt) { return std::abs(felt.displayed.f_Hz - f_Hz); });
}

std::string displayed_row(const FeelSweep& free, const FeelSweep& pressed) {
  std::string row = head_of(free.of.plan) + " " + free.of.integrator + " |" +
                    cell(" %g", free.of.damping_ratio) + cell(" %.0f", 1e3 * drag_of(free.of));
  for (const double f_Hz : decades_Hz) row += cell(" %.1f", 1e3 * at(free, f_Hz).displayed.mass());
  for (const double f_Hz : decades_Hz) row += cell(" %.0f", at(pressed, f_Hz).displayed.stiffness());
  for (const double f_Hz : decades_Hz) row += cell(" %.2f", at(pressed, f_Hz).displayed.damping());
  return row + "\n";
}

/// Returns the frequencies at which counts dominate, Hz: "below 0.3, above 80".
std::string dominated(const FeelSweep& sweep) {
  const CountBand band = count_band(sweep.felt);
  if (band.highest == 0) return " all |";
  std::array<char, 64> text{};
  const bool has_low = band.lowest > 0, has_high = std::isfinite(band.highest);
  if (has_low && has_high)
    std::snprintf(text.data(), text.size(), " below %.2g, above %.2g |", band.lowest, band.highest);
  else if (has_low) std::snprintf(text.data(), text.size(), " below %.2g |", band.lowest);
  else if (has_high) std::snprintf(text.data(), text.size(), " above %.2g |", band.highest);
  else return " none |";
  return text.data();
}

std::string hand_row(const FeelSweep& free, const FeelSweep& pressed) {
  std::string row = head_of(free.of.plan) + cell(" %.2f", 1e3 * delay_of(free.of.plan));
  for (const double f_Hz : decades_Hz) row += cell(" %.1f", 1e3 * at(free, f_Hz).hand.mass());
  for (const double f_Hz : decades_Hz) row += cell(" %.2f", at(free, f_Hz).hand.damping());
  for (const FeelSweep* const sweep : {&free, &pressed})
    row += cell(" %.1f", 1e3 * at(*sweep, 1).ripple_N) + dominated(*sweep);
  return row + "\n";
}

}  // namespace

std::vector<FeelSweep> sweep_feel(int per_decade) {
  std::vector<FeelSweep> sweeps;
  for (const FeelPlan& plan : feel_plans())
    for (const char* const integrator : {"implicit-euler", "tr-bdf2"})
      for (const double damping_ratio : {1.0, 1.4, 2.0})
        for (const bool is_pressed : {false, true}) {
          FeelSweep sweep{.of = {.plan = plan,
                                 .integrator = integrator,
                                 .damping_ratio = damping_ratio,
                                 .is_pressed = is_pressed},
                          .felt = {}};
          for (const double f_Hz : feel_frequencies(per_decade))
            sweep.felt.push_back(measure_feel(sweep.of, f_Hz));
          sweeps.push_back(std::move(sweep));
        }
  return sweeps;
}

std::string feel_tables(const std::vector<FeelSweep>& sweeps) {
  std::string displayed =
      "| plan | count, um | integrator | ratio | drag, mN | free: g at 0.1 Hz | 1 | 10 | 100 | pressed: N/m "
      "at "
      "0.1 Hz | 1 | 10 | 100 | N s/m at 0.1 Hz | 1 | 10 | 100 |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  std::string hand =
      "| plan | count, um | delay, ms | free: g at 0.1 Hz | 1 | 10 | 100 | N s/m at 0.1 Hz | 1 | 10 | 100 | "
      "ripple, mN | counts dominate, Hz | pressed: ripple, mN | counts dominate, Hz |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (std::size_t i = 0; i + 1 < sweeps.size(); i += 2) {
    const FeelCase& c = sweeps[i].of;
    if (!c.plan.has_buses || c.damping_ratio == shown_ratio)
      displayed += displayed_row(sweeps[i], sweeps[i + 1]);
    if (c.plan.has_buses && c.integrator == shown_integrator && c.damping_ratio == shown_ratio)
      hand += hand_row(sweeps[i], sweeps[i + 1]);
  }
  return displayed + "\nOther ratios on buses: `feel.csv`. At the hand, with the device's own mechanics, " +
         shown_integrator + " with a ratio of 1.4; ripple at 1 Hz:\n\n" + hand;
}

}  // namespace godobject::study
