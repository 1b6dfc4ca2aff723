// Prints the state hash of a fixed run of each composition: every compiler, optimisation level and processor
// must print the same. The motion uses only + - * /, so it does not depend on libm.
//   state_hash_probe [STEPS [each]]   each: also prints the quantities of each step
#include <cinttypes>
#include <cstdio>
#include <cstdlib>

#include "core/godobject.h"

namespace {

using namespace godobject;

/// Two bodies go one by one, more in groups of four.
template <class IntegratorPart, class DevicePart, class CouplingPart, class FeedbackPart,
          std::size_t bodies = 2>
struct Composition {
  static constexpr std::size_t max_bodies = bodies;
  using Integrator = IntegratorPart;
  using Device = DevicePart;
  using Coupling = CouplingPart;
  using Joints = None;
  using Feedback = FeedbackPart;
};

template <class IntegratorPart, std::size_t bodies = 2>
using Led = Composition<IntegratorPart, PoseDevice, DampedSpring, LimitedFeedback, bodies>;

/// A tool with every kind of joint, stops and an imposed joint.
template <class IntegratorPart>
struct Tool : Led<IntegratorPart, 7> {
  using Joints = TreeJoints<JointStops, PrescribedJoints>;
};

/// Two bodies on a hinge that touch a plane and a box.
template <class IntegratorPart>
struct Touching : Led<IntegratorPart> {
  using Joints = TreeJoints<>;
  using Contacts = FixedContacts<8, 2, 10>;
};

/// Five bodies that touch each other and a plane; on joints they are two tools.
template <class IntegratorPart, class JointsPart = None>
struct TouchingEachOther : Led<IntegratorPart, 5> {
  using Joints = JointsPart;
  using Contacts = BodyContacts<20, 5, 30>;
};

/// The two tools with other forces between them, and a gear.
template <class IntegratorPart>
struct Forced : TouchingEachOther<IntegratorPart, TreeJoints<JointStops, PrescribedJoints>> {
  using Terms = TermList<DampedSprings<1>, CoordinateSprings<1>, ConstantForces<1>>;
};

/// A tool with a net round it that touches a plane, and a sheet in the scene; attached to the other body.
template <class IntegratorPart>
struct Netted : Led<IntegratorPart> {
  using Contacts = BodyContacts<2, 1, 10>;
  using Net = MassSpringNet<50, 100, 50, 2, 64>;
};

constexpr Real h = 1e-3;
int num_steps = 3000;
bool prints_each = false;

/// Prints a quantity of a step, as bits.
void print_quantity(const char* integrator, const char* scene, int step, std::size_t body,
                    const char* quantity, const Vec3& a, const Vec3& b) {
  std::printf("%s,%s, step %d, body %zu, %s:", integrator, scene + 1, step, body, quantity);
  for (const Vec3& v : {a, b})
    for (Eigen::Index i = 0; i < 3; ++i) std::printf(" %a", static_cast<double>(v[i]));
  std::printf("\n");
}

/// Prints the quantities of all bodies after a step, causes before effects.
template <Scene S>
void print_quantities(const char* scene, int step, const Output<S>& out) {
  if (!prints_each) return;
  for (std::size_t i = 0; i < S::max_bodies; ++i) {
    const BodyOutput<S>& body = out.bodies[i];
    const auto print = [&](const char* quantity, const Vec3& a, const Vec3& b) {
      print_quantity(S::Integrator::name, scene, step, i, quantity, a, b);
    };
    if constexpr (uses<ContactsOf<S>>)
      print("contact force and torque", body.contact.F_W.f, body.contact.F_W.tau);
    if constexpr (uses<typename S::Joints>)
      print("joint force and torque", body.joint.F_C.f, body.joint.F_C.tau);
    print("velocity and angular velocity", body.V_WB.v, body.V_WB.w);
    print("position and quaternion vector", body.X_WB.p, body.X_WB.q.vec());
  }
}

/// Quarter-turn tangent of the motion at step n: to and fro between -1 and 1, once in 1.6 s.
Real tangent(int n) {
  const int phase = n % 1600;
  return (phase < 800 ? phase - 400 : 1200 - phase) / 400.0;
}

/// The target turns about a fixed axis by angles of up to half a turn and moves on a parabola.
void move(PoseDevice::Input& in, int n) {
  const Real t = tangent(n), t_dot = (n % 1600 < 800 ? 1 : -1) / (400 * h);
  const Vec3 u_W(0.36, 0.48, 0.8);
  const Real c = 1 / (1 + t * t);
  in.target.X_WD = {
      .p = Vec3(0.1 * t, 0.05 * t * t, -0.02 * t),
      .q = Quat((1 - t * t) * c, 2 * t * c * u_W.x(), 2 * t * c * u_W.y(), 2 * t * c * u_W.z())};
  in.target.V_WD = {.w = 4 * t_dot * c * u_W, .v = t_dot * Vec3(0.1, 0.1 * t, -0.02)};
  in.valid = n % 37 != 0;
  in.engaged = n % 900 > 30;
}
void move(RelativeDevice::Input& in, int n) {
  in.dp_W = 1e-4 * Vec3(tangent(n), tangent(n + 400), 0.3);
  in.dphi_W = 3e-3 * Vec3(0.2, tangent(n + 100), tangent(n));
  in.clutch = n % 500 > 50;
}
void move(AdmittanceDevice::Input& in, int n) {
  in.F_WB = {.tau = 1e-2 * Vec3(tangent(n), 0.1, 0), .f = Vec3(0.5, tangent(n + 300), tangent(n))};
}
void move(Empty&, int) {}

/// Body i on the one before the last: two branches.
template <Scene S>
void add_joint(Params<S>& par, std::size_t i) {
  constexpr std::array kinds{JointKind::universal, JointKind::cylindrical, JointKind::hinge, JointKind::ball,
                             JointKind::slider,    JointKind::fixed,       JointKind::hinge};
  auto& joint = par.bodies[i].joint;
  joint.kind = kinds[i];
  joint.parent = i < 2 ? world : i - 2;
  joint.P.p = i < 2 ? Vec3(0.1, 0.2, 0.3) : Vec3(0, 0.01, 0.05);
  joint.C.p = Vec3(0.01, 0, -0.05);
  joint.motion.prescribed = i == 2;
  if (kinds[i] == JointKind::hinge || kinds[i] == JointKind::universal)
    joint.stop.stops[0] = {.lower = -0.4, .upper = 0.3, .k = 20, .g = 0.1, .width = 0.05};
}

/// Four spheres on each body, in reach of both surfaces for a part of the motion.
template <Scene S>
void add_contacts(Params<S>& par) {
  par.bodies[1].joint.kind = JointKind::hinge;
  par.bodies[1].joint.parent = 0;
  auto& contacts = par.contacts;
  for (std::size_t k = 0; k < 8; ++k)
    contacts.spheres[contacts.num_spheres++] = {
        .body = k / 4, .p_B = Vec3(k % 2 == 0 ? 0.05 : -0.05, k % 4 < 2 ? 0.03 : -0.03, 0), .radius = 0.02};
  contacts.surfaces[contacts.num_surfaces++] = {
      .shape = {.X_WS = {.p = Vec3(0, 0, -0.02), .q = Quat(0.8, 0, 0.6, 0)}}};
  contacts.surfaces[contacts.num_surfaces++] = {
      .shape = {.kind = ShapeKind::box,
                .X_WS = {.p = Vec3(0.1, 0, 0), .q = Quat(0.6, 0, 0, 0.8)},
                .half_extents = Vec3(0.02, 0.03, 0.04)}};
  contacts.laws[0][0] = {.k = 2e4, .c = 40, .mu = 0.4, .k_t = 1e4, .c_t = 10};
}

/// Four spheres on each body; the last carries none of the shapes and is touched at its spheres.
template <Scene S>
void add_touching(Params<S>& par) {
  auto& contacts = par.contacts;
  for (std::size_t k = 0; k < 20; ++k)
    contacts.spheres[contacts.num_spheres++] = {
        .body = k / 4, .p_B = Vec3(k % 2 == 0 ? 0.05 : -0.05, k % 4 < 2 ? 0.03 : -0.03, 0), .radius = 0.02};
  contacts.surfaces[contacts.num_surfaces++] = {
      .shape = {.X_WS = {.p = Vec3(0, 0, -0.02), .q = Quat(0.8, 0, 0.6, 0)}}};
  for (std::size_t i = 0; i < 4; ++i) {
    Surface& surface = contacts.surfaces[contacts.num_surfaces++];
    surface.body = i;
    if (i % 2 == 0) surface.shape = {.kind = ShapeKind::box, .half_extents = Vec3(0.07, 0.05, 0.02)};
    else surface.shape = {.kind = ShapeKind::capsule, .radius = 0.03, .half_length = 0.04};
  }
  contacts.laws[0][0] = {.k = 2e4, .c = 40, .mu = 0.4, .k_t = 1e4, .c_t = 10};
}

/// A spring between the tools, a gear of their first joints, and a force on a link.
template <Scene S>
void add_terms(Params<S>& par) {
  auto& [springs, gears, forces] = par.terms.of_kinds;
  springs.list[springs.size++] = {.a = {.on = 1, .p = Vec3(0.01, 0, 0)},
                                  .b = {.on = 4, .p = Vec3(0, 0.02, 0)},
                                  .k = 200,
                                  .g = 2,
                                  .l_0 = 0.03};
  gears.list[gears.size++] = {.of = {{{.body = 0, .c = 1, .ratio = 1}, {.body = 1, .c = 0, .ratio = -0.7}}},
                              .size = 2,
                              .k = 2,
                              .g = 0.02};
  forces.list[forces.size++] = {.at = {.on = 3, .p = Vec3(0.01, 0, 0.02)}, .F_W = Vec3(0.5, 0, -1)};
}

/// Two sheets of 5 x 5 with faces: one on the second body, one held in the world by its corners. Each is
/// attached to a body that does not carry it.
template <Scene S>
void add_nets(Params<S>& par) {
  par.contacts.surfaces[par.contacts.num_surfaces++] = {
      .shape = {.X_WS = {.p = Vec3(0, 0, -0.02), .q = Quat(0.8, 0, 0.6, 0)}}};
  par.contacts.laws[0][0] = {.k = 500, .c = 0.2, .mu = 0.4, .k_t = 500, .c_t = 0.1};
  auto& net = par.net;
  for (std::uint32_t n = 0; n < 50; ++n) {
    const std::uint32_t row = n / 5, column = n % 5;
    const bool carried = n < 25, corner = (row == 5 || row == 9) && (column == 0 || column == 4);
    net.nodes[net.num_nodes++] = {.m = 1e-4,
                                  .body = carried ? 1 : world,
                                  .p_B = 0.01 * Vec3(column, row, carried ? 2 : 0),
                                  .k = carried  ? 10.0
                                       : corner ? 100.0
                                                : 0.0,
                                  .g = 0.01,
                                  .radius = 0.004};
    if (column > 0) net.springs[net.num_springs++] = {.i = n - 1, .j = n, .k = 100, .g = 0.01, .l_0 = 0.009};
    if (row % 5 > 0) net.springs[net.num_springs++] = {.i = n - 5, .j = n, .k = 100, .g = 0.01, .l_0 = 0.009};
    if (column == 0 || row % 5 == 0) continue;
    net.faces.list[net.faces.size++] = {.nodes = {n - 6, n - 5, n}};
    net.faces.list[net.faces.size++] = {.nodes = {n - 6, n, n - 1}};
  }
  net.attachments.list[net.attachments.size++] = {
      .node = 12, .body = 0, .p_B = Vec3(0.02, 0.02, 0), .k = 20, .g = 0.02};
  net.attachments.list[net.attachments.size++] = {
      .node = 37, .body = 1, .p_B = Vec3(0.02, 0.02, 0), .k = 20, .g = 0.02};
  put_in_order(net);
}

template <Scene S>
void set_up(Params<S>& par, State<S>& x) {
  par.h = h;
  par.num_bodies = S::max_bodies;
  par.gravity_W = Vec3(0, 0, -9.81);
  if constexpr (uses<ContactsOf<S>>) {
    if constexpr (uses<NetOf<S>>) add_nets(par);
    else if constexpr (ContactsOf<S>::between_bodies) add_touching(par);
    else add_contacts(par);
  }
  if constexpr (uses<TermsOf<S>>) add_terms(par);
  Mat3 I_B;
  I_B << 5e-3, 1e-3, -5e-4, 1e-3, 3e-3, 4e-4, -5e-4, 4e-4, 6e-3;
  for (std::size_t i = 0; i < S::max_bodies; ++i) {
    BodyParams<S>& body = par.bodies[i];
    body.body = rigid_body(i == 0 ? 0.2 : 0.7, I_B);
    if constexpr (prescribes<S>) add_joint(par, i);
    if constexpr (uses<typename S::Coupling>) body.coupling = {.k = 1500, .g = 30, .k_r = 4, .g_r = 0.2};
    if constexpr (uses<typename S::Feedback>) body.feedback.gains = {.k = 800, .g = 1, .k_r = 1, .g_r = 0.02};
    place(x, i,
          {.X_WB = {.p = Vec3(0.1, 0.2, 0.3), .q = Quat(0.5, 0.5, -0.5, 0.5)},
           .V_WB = {.w = Vec3(1, 9, 2), .v = Vec3(0.1, 0, 0.2)}});
  }
  if constexpr (uses<NetOf<S>>) place_net(par.net, x);
}

template <Scene S>
void print_hash(const char* name) {
  Params<S> par;
  State<S> x;
  Scratch<S> w;
  Input<S> in;
  Output<S> out;
  set_up(par, x);
  Hash outputs;
  std::size_t num_contacts = 0;
  for (int n = 0; n < num_steps; ++n) {
    for (std::size_t i = 0; i < S::max_bodies; ++i) move(in.devices[i], n + 250 * static_cast<int>(i));
    if constexpr (prescribes<S>) in.joints[2].q[0] = 0.5 * tangent(n);
    step(par, in, x, w, out);
    print_quantities<S>(name, n, out);
    if (any(out.fault) && out.fault != Fault::contacts_full) std::printf("fault in step %d\n", n);
    outputs.add(out.bodies[1].X_WB);
    outputs.add(out.bodies[1].V_WB);
    if constexpr (uses<typename S::Joints>)
      for (const BodyOutput<S>& body : out.bodies) outputs.add(body.joint.F_C);
    if constexpr (uses<ContactsOf<S>>) {
      for (const BodyOutput<S>& body : out.bodies) outputs.add(body.contact.F_W);
      num_contacts += out.contacts.num_contacts;
      if constexpr (uses<NetOf<S>>) num_contacts += out.net.num_contacts;
    }
  }
  if (uses<ContactsOf<S>> && num_contacts == 0) std::printf("fault: nothing was touched\n");
  std::printf("%-45s %016" PRIx64 " %016" PRIx64 "\n", name, state_hash(par, x), outputs.value());
}

template <class Integrator>
void print_hashes() {
  std::printf("%s\n", Integrator::name);
  print_hash<Composition<Integrator, None, None, None>>("  free");
  print_hash<Led<Integrator>>("  pose, feedback");
  print_hash<Composition<Integrator, RelativeDevice, DampedSpring, LimitedFeedback>>("  relative, feedback");
  print_hash<Composition<Integrator, AdmittanceDevice, None, None>>("  admittance");
  print_hash<Led<Integrator, 5>>("  five bodies");
  print_hash<Tool<Integrator>>("  joints");
  print_hash<Touching<Integrator>>("  contacts");
  print_hash<TouchingEachOther<Integrator>>("  contacts between bodies");
  print_hash<Forced<Integrator>>("  contacts and terms between tools");
  print_hash<Netted<Integrator>>("  nets, faces, attachments");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1) num_steps = std::atoi(argv[1]);
  prints_each = argc > 2;
  print_hashes<ImplicitEuler>();
  print_hashes<TrBdf2>();
}
