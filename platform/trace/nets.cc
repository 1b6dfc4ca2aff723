#include "platform/trace/nets.h"

namespace godobject {

std::vector<std::string> net_trace_columns(const SceneNets& nets) {
  std::vector<std::string> columns{"t"};
  for (const NetRange& net : nets.nets)
    for (std::size_t i = 0; i < net.num_nodes; ++i)
      for (const char* axis : {".x", ".y", ".z"})
        columns.push_back(net.name + "." + std::to_string(i) + axis);
  return columns;
}

NetTraceWriter::NetTraceWriter(CsvRows rows, const SceneNets& nets) : file_(std::move(rows)) {
  file_.header(net_trace_columns(nets));
}

void NetTraceWriter::row(double t, std::span<const Vec3> nodes) {
  file_.number(t);
  for (const Vec3& p_W : nodes) file_.vector(p_W);
  file_.end_row();
}

}  // namespace godobject
