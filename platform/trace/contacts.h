// Contacts of a run as CSV: a row for each contact with a force in a step. World frame, SI. Columns:
//   t
//   body, on      names; for a node the name of its net
//   x y z         contact point
//   nx ny nz      normal, pointing away from `on`
//   fx fy fz      force on `body`
#pragma once

#include <span>
#include <string>
#include <vector>

#include "platform/engine/engine.h"
#include "platform/trace/csv_rows.h"

namespace godobject {

/// Writer of the rows. Not for the real-time thread.
class ContactTraceWriter {
 public:
  ContactTraceWriter(CsvRows rows, const SceneConfig& scene);

  void rows(double t, std::span<const ContactView> contacts);
  /// Writes buffered rows. Returns false if anything was not written.
  [[nodiscard]] bool close() { return file_.close(); }

 private:
  CsvRows file_;
  std::vector<std::string> bodies_, obstacles_,
      nodes_;  // name of each body, of each surface of the world, of each node's net
};

}  // namespace godobject
