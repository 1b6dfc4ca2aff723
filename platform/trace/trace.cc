#include "platform/trace/trace.h"

#include <algorithm>

#include "platform/scene/contact/params.h"
#include "platform/scene/joint/joints.h"

namespace godobject {
namespace {

bool has_contacts(const SceneConfig& scene) { return contact_scope(scene) != ContactScope::none; }

/// Returns the bodies with contact columns.
std::vector<std::size_t> touchable_bodies(const SceneConfig& scene) {
  std::vector<std::size_t> touchable;
  for (std::size_t i = 0; has_contacts(scene) && i < scene.bodies.size(); ++i)
    if (!scene.bodies[i].spheres.empty() || !scene.bodies[i].shapes.empty()) touchable.push_back(i);
  return touchable;
}

void add_device_columns(const SceneConfig& scene, std::vector<std::string>& columns) {
  const TraceDeviceColumns has = device_columns(scene);
  const auto add = [&](const std::string& name, const auto& suffixes) {
    for (const char* suffix : suffixes) columns.push_back(name + suffix);
  };
  if (has.t_bus) columns.emplace_back("t_bus");
  for (const JointConfig& joint : scene.joints) {
    const std::size_t n = num_coordinates(joint.kind);
    for (std::size_t i = 0; i < n; ++i)
      columns.push_back(joint.name + ".q" + (n > 1 ? std::to_string(i + 1) : ""));
  }
  for (const std::string& target : motion_targets(scene)) {
    columns.push_back(target + ".engaged");
    if (has.clutch) columns.push_back(target + ".clutch");
    if (has.poses) add(target + ".device.", pose_columns);
    if (has.wrenches) add(target + ".hand.", wrench_columns);
  }
  if (!scene.device || !scene.device->rig) return;
  for (const DeviceJoint& joint : scene.device->rig->tree.joints)
    columns.push_back("device." + joint.name + ".q");
  for (const DriveParams& drive : scene.device->rig->drives)
    for (const char* const of : {".torque", ".generated"}) columns.push_back("drive." + drive.joint + of);
}

}  // namespace

// ---- run ------------------------------------------------------------------------------------------

std::vector<std::string> trace_columns(const SceneConfig& scene) {
  std::vector<std::string> columns{"t"};
  for (const BodyConfig& body : scene.bodies) {
    for (const char* name : {"x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz"}) {
      columns.push_back(body.name + "." + name);
    }
  }
  for (const std::size_t body : driven_bodies(scene)) {
    for (const char* which : {".coupling.", ".feedback."}) {
      for (const char* name : {"fx", "fy", "fz", "tx", "ty", "tz"}) {
        columns.push_back(scene.bodies[body].name + which + name);
      }
    }
  }
  for (const std::size_t body : driven_bodies(scene)) {
    for (const char* name : {"x", "y", "z", "qw", "qx", "qy", "qz"}) {
      columns.push_back(scene.bodies[body].name + ".target." + name);
    }
  }
  for (const JointConfig& joint : scene.joints) {
    for (const char* name : {"fx", "fy", "fz", "tx", "ty", "tz"}) columns.push_back(joint.name + "." + name);
  }
  for (const std::string& term : term_names(scene))
    for (const char* name : {"fx", "fy", "fz", "tx", "ty", "tz"}) columns.push_back(term + "." + name);
  for (const std::size_t body : touchable_bodies(scene)) {
    for (const char* name : {"fx", "fy", "fz", "tx", "ty", "tz"})
      columns.push_back(scene.bodies[body].name + ".contact." + name);
  }
  if (grips_bodies(scene))
    columns.insert(columns.end(), {"held", "hand.fx", "hand.fy", "hand.fz", "hand.tx", "hand.ty", "hand.tz"});
  columns.push_back("penetration");
  if (has_contacts(scene)) columns.insert(columns.end(), {"contacts", "contact_residual"});
  if (!scene.nets.empty())
    columns.insert(columns.end(),
                   {"net_contacts", "net_penetration", "net_stretch", "net_iterations", "net_residual"});
  columns.insert(columns.end(), {"energy", "energy_balance", "fault", "limited", "rig_fault"});
  add_device_columns(scene, columns);
  return columns;
}

TraceDeviceColumns device_columns(const SceneConfig& scene) {
  TraceDeviceColumns columns{.num_targets = motion_targets(scene).size()};
  for (const JointConfig& joint : scene.joints) columns.num_coordinates += num_coordinates(joint.kind);
  if (!scene.device) return columns;
  columns.t_bus = scene.device->rig || !scene.device->trackers.empty();
  columns.clutch = scene.device->kind == DeviceKind::relative;
  columns.poses = columns.clutch || grips_bodies(scene);
  columns.wrenches = scene.device->kind == DeviceKind::admittance;
  if (!scene.device->rig) return columns;
  columns.num_device_joints = scene.device->rig->tree.joints.size();
  columns.num_drives = scene.device->rig->drives.size();
  return columns;
}

TraceWriter::TraceWriter(CsvRows rows, const SceneConfig& scene)
    : file_(std::move(rows)),
      touchable_(touchable_bodies(scene)),
      contacts_(has_contacts(scene)),
      nets_(!scene.nets.empty()),
      grips_(grips_bodies(scene)),
      device_columns_(device_columns(scene)) {
  file_.header(trace_columns(scene));
}

void TraceWriter::row(double t, std::span<const TraceBody> bodies, std::span<const TraceDriven> driven,
                      std::span<const Wrench> joints, const TraceScene& scene, const TraceBits& bits,
                      const TraceDevices& devices) {
  file_.number(t);
  for (const TraceBody& body : bodies) {
    pose(body.X_WB);
    file_.vector(body.V_WB.v);
    file_.vector(body.V_WB.w);
  }
  for (const TraceDriven& d : driven) {
    wrench(d.coupling);
    wrench(d.feedback);
  }
  for (const TraceDriven& d : driven) pose(d.X_WD);
  for (const Wrench& F : joints) wrench(F);
  for (const std::size_t i : touchable_) wrench(bodies[i].contact);
  if (grips_) {
    file_.number(scene.held ? static_cast<double>(*scene.held) : -1);
    wrench(scene.hand);
  }
  file_.number(scene.contacts.deepest);
  if (contacts_) {
    file_.number(static_cast<double>(scene.contacts.num_contacts));
    file_.number(scene.contacts.residual);
  }
  if (nets_) {
    file_.number(static_cast<double>(scene.nets.num_contacts));
    file_.number(scene.nets.deepest);
    file_.number(scene.net_stretch);
    file_.number(scene.nets.iterations);
    file_.number(scene.nets.residual);
  }
  file_.number(scene.energy);
  file_.number(scene.energy_balance);
  for (const std::uint32_t word : {bits.fault, bits.limited, bits.rig_fault}) file_.number(word);
  row_of(devices);
  file_.end_row();
}

void TraceWriter::row_of(const TraceDevices& devices) {
  const TraceDeviceColumns& has = device_columns_;
  if (has.t_bus) file_.number(devices.t_bus);
  numbers(devices.joint_q, has.num_coordinates);
  for (std::size_t i = 0; i < has.num_targets; ++i) {
    const TargetSample target = i < devices.targets.size() ? devices.targets[i] : TargetSample{};
    file_.number(target.engaged ? 1 : 0);
    if (has.clutch) file_.number(target.clutch ? 1 : 0);
    if (has.poses) pose(target.X_WD);
    if (has.wrenches) wrench(target.F_WB);
  }
  numbers(devices.device_q, has.num_device_joints);
  for (std::size_t i = 0; i < has.num_drives; ++i) {
    numbers(devices.drive_torque.subspan(std::min(i, devices.drive_torque.size())), 1);
    numbers(devices.drive_energy.subspan(std::min(i, devices.drive_energy.size())), 1);
  }
}

void TraceWriter::numbers(std::span<const double> x, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) file_.number(i < x.size() ? x[i] : 0);
}

void TraceWriter::pose(const Pose& X) {
  file_.vector(X.p);
  file_.number(X.q.w());
  file_.vector(X.q.vec());
}

void TraceWriter::wrench(const Wrench& F) {
  file_.vector(F.f);
  file_.vector(F.tau);
}

// ---- contacts -------------------------------------------------------------------------------------

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
    file_.text(contact.is_on_net    ? nodes_[contact.b]
               : contact.b == world ? obstacles_[contact.surface]
                                    : bodies_[contact.b]);
    file_.vector(contact.p_W);
    file_.vector(contact.n_W);
    file_.vector(contact.F_W);
    file_.end_row();
  }
}

// ---- nodes of nets --------------------------------------------------------------------------------

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
