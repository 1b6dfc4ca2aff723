// Jolt: WASM build, single precision. Couplings are its own six-axis motors to a kinematic target, or the forces
// of implicit_pd.mjs. Lengths of contacts are set for tools of centimetres.
import { couplingForce } from './implicit_pd.mjs';
import { addConstraint, addCoupling } from './jolt_constraints.mjs';
import { JoltNet } from './jolt_net.mjs';
import { sample } from './scene.mjs';

export const packageName = 'jolt-physics';

const moving = 0, still = 1, led = 2, numLayers = 3;  // layers: bodies, ground, targets

const edgeRadius = 5e-4;  // m, of boxes: with sharp edges bricks pass through each other

const list = (a) => [a.GetX(), a.GetY(), a.GetZ()];

class Run {
  constructor(jolt, scene, h, variant) {
    Object.assign(this, { jolt, scene, h, variant });
    this.vectors = [0, 1].map(() => new jolt.Vec3(0, 0, 0));
    this.place = new jolt.RVec3(0, 0, 0);
    this.attitude = new jolt.Quat(0, 0, 0, 1);
    this.system = this.makeSystem();
    this.interface = this.system.GetBodyInterfaceNoLock();
    this.setSettings(variant.settings);
    this.bodies = scene.bodies.map((body) => this.addBody(body));
    scene.joints.forEach((joint) => addConstraint(this, joint));
    if (scene.contact) this.addGround();
    if (variant.motors) this.targets = scene.bodies.map((body, i) => this.addTarget(body, i));
  }

  makeSystem() {
    const { jolt } = this, settings = new jolt.JoltSettings();
    const layers = new jolt.ObjectLayerPairFilterTable(numLayers);
    layers.EnableCollision(moving, moving);
    layers.EnableCollision(moving, still);
    const phases = new jolt.BroadPhaseLayerInterfaceTable(numLayers, 1), phase = new jolt.BroadPhaseLayer(0);
    for (let i = 0; i < numLayers; ++i) phases.MapObjectToBroadPhaseLayer(i, phase);
    settings.mObjectLayerPairFilter = layers;
    settings.mBroadPhaseLayerInterface = phases;
    settings.mObjectVsBroadPhaseLayerFilter = new jolt.ObjectVsBroadPhaseLayerFilterTable(phases, 1, layers, numLayers);
    settings.mMaxWorkerThreads = 0;
    this.world = new jolt.JoltInterface(settings);
    jolt.destroy(settings);
    return this.world.GetPhysicsSystem();
  }

  setSettings(changes) {
    const settings = this.system.GetPhysicsSettings();
    const forCentimetres = { mPenetrationSlop: 1e-4, mSpeculativeContactDistance: 1e-3 };  // m
    Object.assign(settings, { mAllowSleeping: false }, forCentimetres, changes);
    this.system.SetPhysicsSettings(settings);
    this.system.SetGravity(this.vec(this.scene.gravity));
  }

  vec([x, y, z], which = 0) {
    this.vectors[which].Set(x, y, z);
    return this.vectors[which];
  }
  at([x, y, z]) {
    this.place.Set(x, y, z);
    return this.place;
  }
  turn([w, x, y, z]) {
    this.attitude.Set(x, y, z, w);
    return this.attitude;
  }

  addBody({ m, I, start: x }, isTarget = false) {
    const { jolt } = this, shape = isTarget || !this.scene.contact ? new jolt.SphereShape(0.01) : this.shape();
    const settings = new jolt.BodyCreationSettings(shape, this.at(x.p), this.turn(x.q),
      isTarget ? jolt.EMotionType_Kinematic : jolt.EMotionType_Dynamic,
      isTarget || !this.scene.contact ? led : moving);
    Object.assign(settings, { mLinearDamping: 0, mAngularDamping: 0, mMaxAngularVelocity: 1e4, mAllowSleeping: false,
      mFriction: this.scene.contact?.mu ?? 0, mApplyGyroscopicForce: !isTarget && this.variant.motors });
    const body = this.interface.CreateBody(settings);
    if (!isTarget) {
      // MassProperties would take small moments for zero.
      body.GetMotionProperties().SetInverseMass(1 / m);
      body.GetMotionProperties().SetInverseInertia(this.vec(I.map((a) => 1 / a)), this.turn([1, 0, 0, 0]));
    }
    this.interface.AddBody(body.GetID(), jolt.EActivation_Activate);
    body.SetLinearVelocity(this.vec(x.v));
    body.SetAngularVelocity(this.vec(x.w));
    jolt.destroy(settings);
    return body;
  }

  /** Returns the shape of every body of a scene with contacts. */
  shape() {
    const { jolt } = this, { centres, radius, half_extents: half } = this.scene.contact;
    if (half) return new jolt.BoxShape(this.vec(half), edgeRadius);
    const settings = new jolt.StaticCompoundShapeSettings(), sphere = new jolt.SphereShape(radius);
    for (const c of centres) settings.AddShapeShape(this.vec(c), this.turn([1, 0, 0, 0]), sphere, 0);
    return settings.Create().Get();
  }

  addGround() {
    const { jolt } = this, half = [2, 2, 0.5];
    const settings = new jolt.BodyCreationSettings(new jolt.BoxShape(this.vec(half), 0), this.at([0, 0, -half[2]]),
      this.turn([1, 0, 0, 0]), jolt.EMotionType_Static, still);
    settings.mFriction = this.scene.contact.mu;
    this.interface.AddBody(this.interface.CreateBody(settings).GetID(), jolt.EActivation_DontActivate);
    jolt.destroy(settings);
  }

  addTarget(body, i) {
    if (!body.coupling) return null;
    const target = this.addBody({ ...body, start: this.scene.motion(0, i) }, true);
    addCoupling(this, target, this.bodies[i], body.coupling);
    return target;
  }

  /** Takes the step from n h to (n + 1) h. */
  step(n) {
    this.scene.bodies.forEach((body, i) => {
      if (!body.coupling) return;
      const D = sample(this.scene, i, (n + 1) * this.h, this.h, this.variant.target);
      if (this.variant.motors) {
        this.targets[i].MoveKinematic(this.at(D.p), this.turn(D.q), this.h);
        return;
      }
      const { f, tau } = couplingForce(body, this.state(i), D, this.h, false);
      this.bodies[i].AddForce(this.vec(f));
      this.bodies[i].AddTorque(this.vec(tau));
    });
    this.world.Step(this.h, 1);
  }

  state(i) {
    const body = this.bodies[i];
    return { ...this.pose(i), v: list(body.GetLinearVelocity()), w: list(body.GetAngularVelocity()) };
  }

  look() {}

  pose(i) {
    const p = list(this.bodies[i].GetPosition()), q = this.bodies[i].GetRotation();
    return { p, q: [q.GetW(), q.GetX(), q.GetY(), q.GetZ()] };
  }

  free() {
    this.jolt.destroy(this.world);
  }
}

const target = { share: 1, mean: true };
const settings = [
  { name: 'Jolt motors', motors: true, target, settings: {}, netIterations: 5 },
  {
    name: 'Jolt motors 50 iterations', motors: true, target, netIterations: 50,
    settings: { mNumVelocitySteps: 50, mNumPositionSteps: 10 },
  },
  { name: 'Jolt forces', motors: false, target, settings: {} },
];

function makeNet(jolt, net, variant) {
  const empty = new Run(jolt, { gravity: [0, 0, -net.gravity], bodies: [], joints: [] }, net.h, variant);
  return new JoltNet({ jolt, world: empty.world, bodies: empty.interface, layer: led }, net, variant.netIterations);
}

export async function variants({ default: initialise }) {
  const jolt = await initialise();
  return settings.map((variant) => ({
    ...variant, can: () => true,
    make: (scene, h) => new Run(jolt, scene, h, variant),
    makeNet: variant.netIterations && ((net) => makeNet(jolt, net, variant)),
  }));
}
