#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/integrator_implicit_euler.h"
#include "core/integrator_tr_bdf2.h"
#include "tests/study/report/results.h"
#include "tests/study/report/text.h"

namespace godobject::study {
namespace {

void write_restitution(std::ostream& out, const ContactErrors& errors) {
  const ContactErrorRow* const second = find(errors.rows, "bounce", TrBdf2::name, 0.25e-3);
  if (!errors.restitution_reference || second == nullptr) return;
  out << "- Restitution of the first bounce by the law: " << number(*errors.restitution_reference, 4) << ".\n"
      << "- At 0.25 ms " << TrBdf2::name << " is within " << number(100 * *second->flight_error, 2)
      << " % of the height and time of every bounce; its first restitution is "
      << number(second->restitution, 4) << ".\n\n";
}

/// Writes the orders per case and integrator, from the longest to the shortest step.
void write_orders(std::ostream& out, const std::vector<ContactErrorRow>& rows) {
  for (auto first = rows.begin(); first != rows.end();) {
    const auto next = std::find_if(first, rows.end(), [&](const ContactErrorRow& r) {
      return r.scene != first->scene || r.integrator != first->integrator;
    });
    const ContactErrorRow& last = *std::prev(next);
    const double halvings = std::log2(first->h / last.h);
    out << "- " << first->scene << ", " << first->integrator << ": order "
        << number(std::log2(first->position / last.position) / halvings, 2) << " of the position";
    if (first->restitution_error)
      out << ", " << number(std::log2(*first->restitution_error / *last.restitution_error) / halvings, 2)
          << " of the first restitution";
    out << ", from " << number(1e3 * first->h) << " to " << number(1e3 * last.h) << " ms.\n";
    first = next;
  }
}

void write_errors(std::ostream& out, const ContactErrors& errors) {
  write_orders(out, errors.rows);
  write_restitution(out, errors);
  out << "![error of contacts against run time](figures/contact-error.png)\n\n"
         "At 1 ms; other steps are in `contact-error.csv`:\n\n"
         "| case | integrator | position, m | penetration, m | energy rise, J | restitution | worst bounce "
         "| ns/step |\n"
         "|---|---|---|---|---|---|---|---|\n";
  for (const ContactErrorRow& r : errors.rows) {
    if (!is_one_ms(r.h)) continue;
    out << "| " << r.scene << " | " << r.integrator << " | " << number(r.position) << " | "
        << number(r.penetration) << " | " << (r.flight_error ? number(r.rise, 2) : "-") << " | "
        << (r.restitution ? number(*r.restitution, 4) : "-") << " | ";
    if (!r.flight_error) out << '-';
    else if (std::isfinite(*r.flight_error)) out << number(100 * *r.flight_error, 2) << " %";
    else out << "one is missing";
    out << " | " << number(r.ns_per_step) << " |\n";
  }
  out << '\n';
}

void write_gains(std::ostream& out, const std::vector<ContactStability>& rows) {
  out << "Over contact stiffness, damping and step: cells, failed ones, those that gain above "
      << number(max_contact_gain) << " J\nbeyond the work of the hand, the largest gain in J:\n\n";
  for (const std::string integrator : {ImplicitEuler::name, TrBdf2::name}) {
    std::size_t cells = 0, failed = 0, gaining = 0;
    double gain = 0;
    for (const ContactStability& r : rows) {
      if (r.integrator != integrator) continue;
      ++cells;
      failed += r.failed ? 1 : 0;
      if (r.failed) continue;
      gaining += r.gain > max_contact_gain ? 1 : 0;
      gain = std::max(gain, r.gain);
    }
    out << "- " << integrator << ": " << cells << ", " << failed << ", " << gaining << ", " << number(gain, 2)
        << '\n';
  }
  out << "\n![stability of contacts](figures/contact-stability.png)\n\n";
}

void write_imposed(std::ostream& out, const std::vector<PileRun>& runs) {
  out << "The same motions of the scene lego, its held brick a god-object, and placed at the device's pose. "
         "Plunging, the device goes 30 mm into the pile within 10 ms:\n\n"
         "| coupling | deepest contact, m | largest contact force on the held brick, N | energy given to the "
         "others, J | "
         "ejected of "
      << runs.front().bricks
      << " | steps with a fault | largest residual, N |\n|---|---|---|---|---|---|---|\n";
  for (const PileRun& run : runs)
    out << "| " << run.coupling << " | " << number(run.worst.overlap) << " | " << number(run.worst.force)
        << " | " << number(run.worst.energy) << " | " << run.worst.ejected << " | " << run.num_faults << " | "
        << number(run.worst.residual, 2) << " |\n";
  out << "\n![imposed and god-object](figures/contact-imposed.png)\n\n"
         "A ball pressed into a valley of one mesh (`tests/study/scenes/valley.toml`), and of two planes:\n\n"
         "![a ball in a valley](figures/valley.png)\n\n";
}

const ContactCostRow* find_cost(const std::vector<ContactCostRow>& rows, const std::string& composition,
                                const std::string& motion) {
  const auto row = std::ranges::find_if(
      rows, [&](const ContactCostRow& r) { return r.size.composition == composition && r.motion == motion; });
  return row == rows.end() ? nullptr : &*row;
}

std::string more(const std::optional<double>& with, const std::optional<double>& without) {
  return with && without ? std::to_string(std::lround(*with - *without)) : "not available";
}

/// Writes the instructions added by friction to a step of S2, for each integrator.
void write_friction(std::ostream& out, const std::vector<ContactCostRow>& rows) {
  for (const std::string integrator : {ImplicitEuler::name, TrBdf2::name}) {
    const ContactCostRow *const none = find_cost(rows, "pressed-1 " + integrator, "s2"),
                                *const smooth =
                                    find_cost(rows, "pressed-contacts-1 " + integrator, "s2-smooth"),
                                *const rough = find_cost(rows, "pressed-contacts-1 " + integrator, "s2");
    if (none == nullptr || smooth == nullptr || rough == nullptr) continue;
    out << "- " << integrator << ": ten contacts add " << more(smooth->instructions, none->instructions)
        << " instructions to a step of S2, their friction " << more(rough->instructions, smooth->instructions)
        << ".\n";
  }
  out << '\n';
}

void write_costs(std::ostream& out, const std::vector<ContactCostRow>& rows) {
  if (rows.empty()) {
    out << "What contacts cost: not available.\n\n";
    return;
  }
  out << "What contacts cost:\n\n";
  write_friction(out, rows);
  out << "Bytes and instructions of all compositions: `contact-cost.csv`. Without contacts the tool passes "
         "through all.\n\n";
}

}  // namespace

void write_contacts(std::ostream& out, const StudyResults& results) {
  out << "### 5. Contacts\n\n";
  write_errors(out, results.contact_errors);
  write_gains(out, results.contact_stability);
  if (!results.piles.empty()) write_imposed(out, results.piles);
  write_costs(out, results.contact_costs);
}

}  // namespace godobject::study
