// Engine for one scene type. Included only by the files that instantiate compositions.
#pragma once

#include <cstring>

#include "core/godobject.h"
#include "core/setup.h"
#include "platform/engine/engine.h"
#include "platform/engine/params_of.h"
#include "platform/scene/contact/params.h"

namespace godobject {

template <Scene S>
constexpr ContactScope scope_of() noexcept {
  if constexpr (!uses<ContactsOf<S>>) return ContactScope::none;
  else return ContactsOf<S>::between_bodies ? ContactScope::bodies : ContactScope::obstacles;
}

/// Returns the rotation from the z axis to a unit vector, about an axis normal to both.
inline Quat turned_from_z(const Vec3& n) noexcept {
  constexpr Real opposite = 1e-9;
  if (n.z() < opposite - 1) return Quat(0, 1, 0, 0);
  return Quat(1 + n.z(), -n.y(), n.x(), 0).normalized();
}

template <Scene S>
class EngineOf final : public Engine {
 public:
  /// Converts the scene's parameters. Call start() once validity() is Invalid::nothing.
  EngineOf(const SceneConfig& scene, Composition composition)
      : composition_(std::move(composition)), par_(params_of<S>(scene)) {
    if constexpr (uses<ContactsOf<S>>) {
      contacts_ = scene_contacts(scene);
      while (first_plane_ < contacts_.surfaces.size() && contacts_.surfaces[first_plane_].body == world)
        ++first_plane_;
      first_plane_ -= scene.world_planes;
      set_contact_params(contacts_, par_.contacts);
    }
    if constexpr (uses<TermsOf<S>>) {
      set_terms(scene, par_.terms);
      num_gears_ = scene.gears.size();
    }
    if constexpr (uses<NetOf<S>>) {
      nets_ = scene_nets(scene);
      set_net_params(nets_, par_.net);
    }
  }

  /// Validates the scene's parameters by the core.
  Validity validity() const noexcept { return validate(par_); }

  /// Places bodies and nets and engages the devices, whose samples at t = 0 are at_start.
  void start(const SceneConfig& scene, std::span<const BodySample> at_start) {
    for (std::size_t i = 0; i < par_.num_bodies; ++i) {
      place(x_, i, {.X_WB = scene.bodies[i].X_WB, .V_WB = scene.bodies[i].V_WB});
      const AnyDevice::Params& device = par_.bodies[i].device;
      const Target& sample = before_[i] = at_start[i].target;
      const bool absolute = device.kind == AnyDevice::Kind::pose;
      engage_at(x_, i, absolute ? sample : Target{.X_WD = scene.bodies[i].X_WB, .V_WD = {}});
      const bool captures = device.kind == AnyDevice::Kind::holding;  // in its first step
      const bool at_once = device.rise == 0 && at_start[i].engaged && !captures;
      if (!at_once) x_.bodies[i].device.ramp = {};
    }
    if constexpr (prescribes<S>) {
      for (const JointConfig& joint : scene.joints)
        x_.bodies[*body_named(scene, joint.child)].joint.last.q = coordinates_at_start(scene.bodies, joint);
    }
    start_turns(par_, x_);
    if constexpr (counts_turns<S>) {
      for (const JointConfig& joint : scene.joints) {
        // the key `start` selects the turn; the places of the bodies give the angle, rounded as in each step
        auto& q = x_.bodies[*body_named(scene, joint.child)].joint.q;
        q = unwrapped(q, coordinates_at_start(scene.bodies, joint), num_axes(joint.kind).turns);
      }
    }
    if constexpr (uses<NetOf<S>>) place_net(par_.net, x_);
    balance_.start(par_, x_);
  }

  const Composition& composition() const noexcept override { return composition_; }

  StepReport step(std::span<const BodySample> samples) noexcept override {
    for (std::size_t i = 0; i < par_.num_bodies; ++i) {
      set_input(par_.bodies[i].device.kind, samples[i], before_[i], in_.devices[i]);
      if (samples[i].valid) before_[i] = samples[i].target;
      if constexpr (prescribes<S>) in_.joints[i] = samples[i].joint;
    }
    godobject::step(par_, in_, x_, w_, out_);
    StepReport report{.fault = out_.fault, .limited = out_.limited, .contacts = {}, .nets = {}};
    if (x_.tick != tick_) balance_.observe(par_, x_, w_, out_);  // the step was taken
    tick_ = x_.tick;
    if (balance_.gains()) report.fault |= Fault::energy_gained;
    if constexpr (uses<ContactsOf<S>>) report.contacts = out_.contacts;
    if constexpr (uses<NetOf<S>>) report.nets = out_.net;
    return report;
  }

  void pass_time(double s) noexcept override {
    for (std::size_t i = 0; i < par_.num_bodies; ++i) godobject::pass_time(x_.bodies[i].device, s, par_.h);
  }

  BodyView view(std::size_t i) const noexcept override {
    BodyView v{.X_WB = x_.bodies[i].x.X_WB,
               .V_WB = {.w = to_world(x_.bodies[i].x.X_WB.q, x_.bodies[i].x.w_B), .v = x_.bodies[i].x.v_W},
               .target = x_.bodies[i].device.last,
               .feedback_D = feedback(i),
               .coupling_B = balance_.coupling(i).F_WB,
               .joint_C = {},
               .contact_W = {}};
    if constexpr (uses<typename S::Joints>) v.joint_C = out_.bodies[i].joint.F_C;
    if constexpr (uses<ContactsOf<S>>) v.contact_W = out_.bodies[i].contact.F_W;
    return v;
  }

  Wrench feedback(std::size_t i) const noexcept override { return out_.bodies[i].feedback.F_D; }

  EnergyReport energy() const noexcept override {
    const GainWatch& watch = balance_.watch();
    return {.total = balance_.energy(),
            .balance = balance_.balance(),
            .gained = watch.gained(),
            .at_work = watch.at_work()};
  }

  std::size_t contacts(std::span<ContactView> out) const noexcept override {
    std::size_t n = 0;
    if constexpr (uses<ContactsOf<S>>) {
      const auto add = [&](const auto& forces, bool is_node) {
        for (std::size_t i = 0; i < forces.size && n < out.size(); ++i) {
          const ContactForce& one = forces.list[i];
          const bool on_world =
              one.on < par_.contacts.num_surfaces && par_.contacts.surfaces[one.on].body == world;
          out[n++] = {.a = one.a,
                      .b = on_world ? world : std::size_t{one.b},
                      .is_node = is_node,
                      .surface = on_world ? one.on : 0,
                      .p_W = one.p_W,
                      .n_W = one.n_W,
                      .F_W = one.F_W};
        }
      };
      add(w_.means.contacts, false);
      if constexpr (uses<NetOf<S>>) {
        const std::size_t first = n;
        add(w_.means.of_nodes, true);
        for (std::size_t i = first; i < n; ++i) {
          const ContactForce& one = w_.means.of_nodes.list[i - first];
          if (one.b != NetContactTerm::on_net) continue;
          out[i].is_on_net = true;
          out[i].b = par_.net.faces.list[one.on - first_face_number<ContactsOf<S>>].nodes[0];
        }
      }
    }
    return n;
  }

  const SceneNets& nets() const noexcept override { return nets_; }

  std::size_t net_nodes(std::span<Vec3> p_W) const noexcept override {
    const std::size_t n = std::min(num_net_nodes(par_), p_W.size());
    if constexpr (uses<NetOf<S>>)
      for (std::size_t i = 0; i < n; ++i) p_W[i] = x_.net.nodes[i].p_W;
    return n;
  }

  double net_stretch() const noexcept override {
    double most = 0;
    if constexpr (uses<NetOf<S>>) {
      for (std::size_t s = 0; s < par_.net.num_springs; ++s) {
        const NetSpring& spring = par_.net.springs[s];
        most = std::max(most, (x_.net.nodes[spring.j].p_W - x_.net.nodes[spring.i].p_W).norm() / spring.l_0);
      }
    }
    return most;
  }

  void term_forces(std::span<Wrench> F_W) const noexcept override {
    if constexpr (uses<TermsOf<S>>) {
      std::size_t n = 0, first = 0;
      const auto add = [&](std::size_t reported, std::size_t size) {
        for (std::size_t t = 0; t < reported && n < F_W.size(); ++t) F_W[n++] = out_.terms.list[first + t];
        first += size;
      };
      const auto& kinds = par_.terms.of_kinds;
      add(std::get<0>(kinds).size, std::get<0>(kinds).size);
      add(num_gears_, std::get<1>(kinds).size);
      add(std::get<2>(kinds).size, std::get<2>(kinds).size);
    }
  }

  std::uint64_t state_hash() const noexcept override { return godobject::state_hash(par_, x_); }

  std::size_t first_plane() const noexcept override { return first_plane_; }

  void set_plane(std::size_t i, const ContactPlane& plane) noexcept override {
    if constexpr (uses<ContactsOf<S>>) {
      Surface& surface = par_.contacts.surfaces[first_plane_ + i];
      surface.shape.X_WS = {.p = plane.p_W, .q = turned_from_z(plane.n_W)};
      auto& laws = par_.contacts.laws;
      for (std::size_t m = 0; m < laws.size(); ++m)
        laws[m][surface.material] = laws[surface.material][m] = {.k = plane.k, .c = plane.c};
    }
  }

  double depth_below(const Vec3& p_W, const Vec3& n_W) const noexcept override {
    double deepest = -std::numeric_limits<double>::infinity();
    if constexpr (uses<ContactsOf<S>>) {
      const auto add = [&](std::size_t body, const Vec3& p_B, Real radius) noexcept {
        const Pose& X = x_.bodies[body].x.X_WB;
        deepest = std::max<double>(deepest, n_W.dot(p_W - X.p - to_world(X.q, p_B)) + radius);
      };
      const auto& contacts = par_.contacts;
      for (std::size_t i = 0; i < contacts.num_spheres; ++i)
        add(contacts.spheres[i].body, contacts.spheres[i].p_B, contacts.spheres[i].radius);
      for (std::size_t i = 0; i < contacts.num_surfaces; ++i) {
        const Surface& surface = contacts.surfaces[i];
        if (surface.body == world) continue;
        const ShapeParams& shape = surface.shape;
        for (std::uint32_t j = 0; j < num_points(shape.kind); ++j) {
          const ShapePoint point = point_of(shape, j, half_thickness(shape));
          const Real radius = shape.kind == ShapeKind::box ? 0 : point.r;
          add(surface.body, shape.X_WS.p + to_world(shape.X_WS.q, Vec3(point.p_S + point.tip_S)), radius);
        }
      }
    }
    return deepest;
  }

  std::size_t snapshot_bytes() const noexcept override {
    std::size_t size = 0;
    each_kept(*this, [&](const auto& member) { size += padded(sizeof member); });
    return size;
  }

  void save(std::span<std::byte> out) const noexcept override {
    each_kept(*this, [&](const auto& member) {
      std::memcpy(out.data(), static_cast<const void*>(&member), sizeof member);
      out = out.subspan(padded(sizeof member));
    });
  }

  bool restore(std::span<const std::byte> in) noexcept override {
    if (in.size() != snapshot_bytes()) return false;
    each_kept(*this, [&](auto& member) {
      std::memcpy(static_cast<void*>(&member), in.data(), sizeof member);
      in = in.subspan(padded(sizeof member));
    });
    if constexpr (uses<NetOf<S>>)
      if (!fits(x_.net.contacts)) return false;
    return fits(x_.contacts);
  }

 private:
  /// Visits the members that a step leaves to the next. Their types have neither pointers nor heap, so their
  /// bytes are their value.
  template <class Self, class Visit>
  static void each_kept(Self& self, Visit visit) noexcept {
    visit(self.x_);
    visit(self.balance_);
    visit(self.before_);
    visit(self.tick_);
  }
  static constexpr std::size_t padded(std::size_t bytes) noexcept { return (bytes + 7) / 8 * 8; }
  /// True if the size of a list is within its capacity.
  template <class List>
  static bool fits(const List& contacts) noexcept {
    if constexpr (requires { contacts.list.size(); }) return contacts.size <= contacts.list.size();
    else return true;
  }

  Composition composition_;
  [[no_unique_address]] std::conditional_t<uses<ContactsOf<S>>, SceneContacts, Empty> contacts_;
  SceneNets nets_;
  Params<S> par_;  // refers to contacts_
  State<S> x_;
  Scratch<S> w_;
  Input<S> in_;
  Output<S> out_;
  EnergyBalance<S> balance_;
  std::uint64_t tick_ = 0;
  std::size_t first_plane_ = 0;
  std::size_t num_gears_ = 0;                 // before the springs of joints among the springs on coordinates
  std::array<Target, S::max_bodies> before_;  // previous valid target, for increments
};

/// Makes and starts an engine. Returns null, with the violated rule in `validity`, if the core rejects the
/// scene's parameters.
template <Scene S>
std::unique_ptr<Engine> make_engine_of(const SceneConfig& scene, std::span<const BodySample> at_start,
                                       const Composition& composition, Validity& validity) {
  auto engine = std::make_unique<EngineOf<S>>(scene, composition);
  validity = engine->validity();
  if (validity != Invalid::nothing) return nullptr;
  engine->start(scene, at_start);
  return engine;
}

}  // namespace godobject
