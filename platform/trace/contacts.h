// The contacts of a run as CSV: a row for every contact that bears a force in a step, with t, body and on (names; body: of the
// net where it is one of a node), the
// contact point x y z, the normal nx ny nz off `on`, and the force fx fy fz on `body`. World frame, SI.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "platform/engine/engine.h"
#include "platform/trace/csv_rows.h"

namespace godobject {

/// Not for the real-time thread.
class ContactTraceWriter {
 public:
  ContactTraceWriter(CsvRows rows, const SceneConfig& scene);

  void rows(double t, std::span<const ContactView> contacts);
  /// Writes what is left. False when anything did not reach the file.
  [[nodiscard]] bool close() { return file_.close(); }

 private:
  CsvRows file_;
  std::vector<std::string> bodies_, obstacles_,
      nodes_;  // names: of each body, each surface of the world, each node's net
};

}  // namespace godobject
