// Every composition of the core's parts, instantiated once, so that the archive has all symbols that a linker
// would need.
#include "core/godobject.h"

namespace godobject {

template <class IntegratorPart, class DevicePart, class CouplingPart, class FeedbackPart,
          class JointsPart = None>
struct Composition {
  static constexpr int max_bodies = 4;
  using Integrator = IntegratorPart;
  using Device = DevicePart;
  using Coupling = CouplingPart;
  using Joints = JointsPart;
  using Feedback = FeedbackPart;
};

/// With contacts, and so with every kind of shape.
template <class IntegratorPart>
struct Touching : Composition<IntegratorPart, PoseDevice, DampedSpring, LimitedFeedback, TreeJoints<>> {
  using Contacts = FixedContacts<8, 2, 16>;
};

/// Bodies that touch each other.
template <class IntegratorPart>
struct TouchingEachOther : Composition<IntegratorPart, PoseDevice, DampedSpring, LimitedFeedback> {
  using Contacts = BodyContacts<8, 4, 16>;
};

/// With a net that touches bodies.
template <class IntegratorPart>
struct WithANet : Composition<IntegratorPart, PoseDevice, DampedSpring, LimitedFeedback, TreeJoints<>> {
  using Contacts = BodyContacts<8, 4, 16>;
  using Net = MassSpringNet<16, 48, 32>;
};

/// Calls all that the core offers to a scene; instantiating the class emits its functions.
template <Scene S>
struct Probe {
  static Invalid set_up(const Params<S>& par, Real m, const Mat3& I_B, const Start& start,
                        BodyParams<S>& body, State<S>& x) noexcept {
    body.body = rigid_body(m, I_B);
    for (std::size_t i = 0; i < par.num_bodies; ++i) {
      place(x, i, start);
      if constexpr (uses<typename S::Device>) engage_at(x, i, {.X_WD = start.X_WB, .V_WD = start.V_WB});
    }
    return validate(par);
  }

  static void run(const Params<S>& par, const Input<S>& in, State<S>& x, Scratch<S>& w,
                  Output<S>& out) noexcept {
    step(par, in, x, w, out);
  }

  static std::uint64_t hash(const Params<S>& par, const State<S>& x) noexcept { return state_hash(par, x); }

  static Real energy(const Params<S>& par, const State<S>& x) noexcept {
    Real E = kinetic_energy(par.bodies[0].body, x.bodies[0].x);
    if constexpr (uses<typename S::Coupling>)
      E += coupling_at(par, x, 0).energy + coupling_at(par, x, 0).F_WB.f.x();
    return E;
  }
};

template struct Probe<Composition<ImplicitEuler, None, None, None>>;
template struct Probe<Composition<ImplicitEuler, PoseDevice, DampedSpring, None>>;
template struct Probe<Composition<ImplicitEuler, PoseDevice, DampedSpring, LimitedFeedback>>;
template struct Probe<Composition<ImplicitEuler, RelativeDevice, DampedSpring, None>>;
template struct Probe<Composition<ImplicitEuler, RelativeDevice, DampedSpring, LimitedFeedback>>;
template struct Probe<Composition<ImplicitEuler, AdmittanceDevice, None, None>>;
template struct Probe<Composition<ImplicitEuler, AdmittanceDevice, DampedSpring, None>>;
template struct Probe<Composition<ImplicitEuler, AdmittanceDevice, DampedSpring, LimitedFeedback>>;
template struct Probe<Composition<ImplicitEuler, PoseDevice, DampedSpring, LimitedFeedback,
                                  TreeJoints<JointStops, PrescribedJoints>>>;
template struct Probe<Composition<TrBdf2, None, None, None>>;
template struct Probe<
    Composition<TrBdf2, PoseDevice, DampedSpring, LimitedFeedback, TreeJoints<JointStops, PrescribedJoints>>>;
template struct Probe<Composition<TrBdf2, PoseDevice, DampedSpring, None>>;
template struct Probe<Composition<TrBdf2, PoseDevice, DampedSpring, LimitedFeedback>>;
template struct Probe<Composition<TrBdf2, RelativeDevice, DampedSpring, None>>;
template struct Probe<Composition<TrBdf2, RelativeDevice, DampedSpring, LimitedFeedback>>;
template struct Probe<Composition<TrBdf2, AdmittanceDevice, None, None>>;
template struct Probe<Composition<TrBdf2, AdmittanceDevice, DampedSpring, None>>;
template struct Probe<Composition<TrBdf2, AdmittanceDevice, DampedSpring, LimitedFeedback>>;
template struct Probe<Touching<ImplicitEuler>>;
template struct Probe<Touching<TrBdf2>>;
template struct Probe<TouchingEachOther<ImplicitEuler>>;
template struct Probe<TouchingEachOther<TrBdf2>>;
template struct Probe<WithANet<ImplicitEuler>>;
template struct Probe<WithANet<TrBdf2>>;

}  // namespace godobject
