#include "platform/trace/contacts.h"

#include "platform/scene/contact/params.h"

namespace godobject {

ContactTraceWriter::ContactTraceWriter(CsvRows rows, const SceneConfig& scene) : file_(std::move(rows)) {
  for (const BodyConfig& body : scene.bodies) bodies_.push_back(body.name);
  for (const ObstacleConfig& obstacle : scene.obstacles)
    obstacles_.insert(obstacles_.end(), num_solids(obstacle), obstacle.name);
  for (const NetRange& net : scene_nets(scene).nets) nodes_.insert(nodes_.end(), net.num_nodes, net.name);
  file_.header({"t", "body", "on", "x", "y", "z", "nx", "ny", "nz", "fx", "fy", "fz"});
}

void ContactTraceWriter::rows(double t, std::span<const ContactView> contacts) {
  for (const ContactView& contact : contacts) {
    file_.number(t);
    file_.text(contact.is_node ? nodes_[contact.a] : bodies_[contact.a]);
    file_.text(contact.b == world ? obstacles_[contact.surface] : bodies_[contact.b]);
    file_.vector(contact.p_W);
    file_.vector(contact.n_W);
    file_.vector(contact.F_W);
    file_.end_row();
  }
}

}  // namespace godobject
