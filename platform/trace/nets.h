// Positions of the nodes of nets as CSV: a row per frame, with t and for every node <net>.<number>.x y z.
// World frame, m. Numbers are those of the net's surface, in the order of Engine::nets().
#pragma once

#include <span>
#include <string>
#include <vector>

#include "platform/scene/net/params.h"
#include "platform/trace/csv_rows.h"

namespace godobject {

/// Writer of the rows. Not for the real-time thread.
class NetTraceWriter {
 public:
  NetTraceWriter(CsvRows rows, const SceneNets& nets);

  void row(double t, std::span<const Vec3> nodes);
  /// Writes buffered rows. Returns false if anything was not written.
  [[nodiscard]] bool close() { return file_.close(); }

 private:
  CsvRows file_;
};

/// Returns the columns of the header line.
std::vector<std::string> net_trace_columns(const SceneNets& nets);

}  // namespace godobject
