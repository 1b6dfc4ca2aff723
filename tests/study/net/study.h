// Nets: error against run time, and cost per node.
#pragma once

#include "tests/study/footprint_study.h"

namespace godobject::study {

/// The small net of tests/net (25 nodes on a body that oscillates for 0.128 s) at one step.
struct NetErrorRow {
  std::string scene;  // "free", "pressed" on a plane
  std::string integrator;
  double h = 0;                 // s
  double position = 0;          // m, largest error of a node or the body at the end
  double share = 0;             // share of the net's deformation
  std::optional<double> order;  // log2 of the error at 2 h over the error at h
  double ns_per_step = 0;
};

/// A tube of S6, pressed.
struct NetCostRow {
  std::string integrator;
  std::size_t nodes = 0;
  double ns_per_step = 0, ns_p99 = 0;   // median, and 99th percentile
  double iterations = 0, contacts = 0;  // means
  std::optional<double> instructions;   // per step with 1024 nodes
  std::size_t params_bytes = 0, state_bytes = 0, scratch_bytes = 0;
};

struct NetResults {
  std::vector<NetErrorRow> errors;
  double deformation_free = 0, deformation_pressed = 0;  // m
  std::vector<NetCostRow> costs;
};

NetResults study_nets(bool quick, InstructionCounter& counter, const Progress& progress);

void write_csv(const std::filesystem::path& file, const std::vector<NetErrorRow>& rows);
void write_csv(const std::filesystem::path& file, const std::vector<NetCostRow>& rows);
void write_net_script(const std::filesystem::path& directory);

}  // namespace godobject::study
