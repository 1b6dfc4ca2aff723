#include "sim/trace.h"

#include <array>
#include <charconv>
#include <fstream>
#include <memory>

#include "sim/contact_pairs.h"

namespace godobject {

inline constexpr std::size_t buffer_size = 1 << 16;  // bytes

namespace {

bool has_contacts(const SceneConfig& scene) { return contact_scope(scene) != ContactScope::none; }

/// Bodies with contact columns.
std::vector<std::size_t> touchable_bodies(const SceneConfig& scene) {
  std::vector<std::size_t> touchable;
  for (std::size_t i = 0; has_contacts(scene) && i < scene.bodies.size(); ++i)
    if (!scene.bodies[i].spheres.empty() || !scene.bodies[i].shapes.empty()) touchable.push_back(i);
  return touchable;
}

}  // namespace

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
  for (const std::size_t body : touchable_bodies(scene)) {
    for (const char* name : {"fx", "fy", "fz", "tx", "ty", "tz"})
      columns.push_back(scene.bodies[body].name + ".contact." + name);
  }
  if (takes_hold(scene))
    columns.insert(columns.end(), {"held", "hand.fx", "hand.fy", "hand.fz", "hand.tx", "hand.ty", "hand.tz"});
  columns.push_back("penetration");
  if (has_contacts(scene)) columns.insert(columns.end(), {"contacts", "contact_residual"});
  columns.insert(columns.end(), {"fault", "limited", "rig_fault"});
  return columns;
}

namespace {

TraceWriter::Sink file_sink(const std::string& path) {
  return [file = std::make_shared<std::ofstream>(path, std::ios::binary)](std::string_view text) {
    file->write(text.data(), static_cast<std::streamsize>(text.size()));
    return !file->flush().fail();
  };
}

}  // namespace

TraceWriter::TraceWriter(const std::string& path, const SceneConfig& scene)
    : TraceWriter(file_sink(path), scene) {}

TraceWriter::TraceWriter(Sink sink, const SceneConfig& scene)
    : sink_(std::move(sink)),
      touchable_(touchable_bodies(scene)),
      contacts_(has_contacts(scene)),
      grips_(takes_hold(scene)) {
  buffer_.reserve(2 * buffer_size);
  for (const std::string& column : trace_columns(scene)) buffer_ += column + ",";
  buffer_.back() = '\n';
}

void TraceWriter::row(double t, std::span<const TraceBody> bodies, std::span<const TraceDriven> driven,
                      std::span<const Wrench> joints, const TraceScene& scene, const TraceBits& bits) {
  number(t);
  for (const TraceBody& body : bodies) {
    pose(body.X_WB);
    vector(body.V_WB.v);
    vector(body.V_WB.w);
  }
  for (const TraceDriven& d : driven) {
    wrench(d.coupling);
    wrench(d.feedback);
  }
  for (const TraceDriven& d : driven) pose(d.X_WD);
  for (const Wrench& F : joints) wrench(F);
  for (const std::size_t i : touchable_) wrench(bodies[i].contact);
  if (grips_) {
    number(scene.held ? static_cast<double>(*scene.held) : -1);
    wrench(scene.hand);
  }
  number(scene.contacts.deepest);
  if (contacts_) {
    number(static_cast<double>(scene.contacts.num_contacts));
    number(scene.contacts.residual);
  }
  for (const std::uint32_t word : {bits.fault, bits.limited, bits.rig_fault}) number(word);
  buffer_.back() = '\n';
  if (buffer_.size() > buffer_size) flush();
}

bool TraceWriter::close() {
  flush();
  return all_taken_;
}

void TraceWriter::number(double x) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), x).ptr;
  buffer_.append(text.data(), end);
  buffer_ += ',';
}

void TraceWriter::vector(const Vec3& a) {
  for (int i = 0; i < 3; ++i) number(a[i]);
}

void TraceWriter::pose(const Pose& X) {
  vector(X.p);
  number(X.q.w());
  vector(X.q.vec());
}

void TraceWriter::wrench(const Wrench& F) {
  vector(F.f);
  vector(F.tau);
}

void TraceWriter::flush() {
  if (!buffer_.empty()) all_taken_ = sink_(buffer_) && all_taken_;
  buffer_.clear();
}

}  // namespace godobject
