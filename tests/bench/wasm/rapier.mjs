// Rapier: WASM build, single precision. Couplings are forces of implicit_pd.mjs.
import { couplingForce } from './implicit_pd.mjs';
import { scale } from './math.mjs';
import { sample } from './scene.mjs';

export const packageName = '@dimforge/rapier3d-compat';

const light = { m: 1e-6, I: [1e-9, 1e-9, 1e-9] };  // kg, kg m^2
const vector = ([x, y, z]) => ({ x, y, z }), turn = ([w, x, y, z]) => ({ w, x, y, z });
const list = ({ x, y, z }) => [x, y, z];

class Run {
  constructor(rapier, scene, h, variant) {
    Object.assign(this, { rapier, scene, h, variant });
    this.world = new rapier.World(vector(scene.gravity));
    this.world.timestep = h;
    Object.assign(this.world.integrationParameters, variant.parameters);
    this.bodies = scene.bodies.map((body) => this.world.createRigidBody(this.description(body)));
    this.ground = this.world.createRigidBody(rapier.RigidBodyDesc.fixed());
    scene.joints.forEach((joint) => this.addJoint(joint));
    if (scene.contact) this.addShapes(scene.contact);
  }

  addShapes({ centres, radius, half_extents: half, mu }) {
    const { ColliderDesc, CoefficientCombineRule } = this.rapier;
    const add = (shape, body) => this.world.createCollider(
      shape.setDensity(0).setFriction(mu).setFrictionCombineRule(CoefficientCombineRule.Min), body);
    add(ColliderDesc.cuboid(2, 2, 0.5).setTranslation(0, 0, -0.5), this.ground);
    for (const body of this.bodies)
      if (half) add(ColliderDesc.cuboid(...half), body);
      else for (const c of centres) add(ColliderDesc.ball(radius).setTranslation(...c), body);
  }

  description({ m, I, start: x }) {
    return this.rapier.RigidBodyDesc.dynamic().setTranslation(...x.p).setRotation(turn(x.q)).setLinvel(...x.v)
      .setAngvel(vector(x.w)).setCanSleep(false)
      .setAdditionalMassProperties(m, vector([0, 0, 0]), vector(I), turn([1, 0, 0, 0]));
  }

  addJoint(joint) {
    const { JointData, JointAxesMask } = this.rapier, P = vector(joint.anchor_P), C = vector(joint.anchor_C);
    const parent = joint.parent === null ? this.ground : this.bodies[joint.parent], child = this.bodies[joint.child];
    const add = (data, a, b) => this.variant.reduced ? this.world.createMultibodyJoint(data, a, b, true)
      : this.world.createImpulseJoint(data, a, b, true);
    const { LinY, LinZ, AngY, AngZ } = JointAxesMask;
    switch (joint.type) {
      case 'ball': return add(JointData.spherical(P, C), parent, child);
      case 'hinge': return add(JointData.revolute(P, C, vector(joint.axis_P)), parent, child);
      case 'cylindrical':
        return add(JointData.generic(P, C, vector(joint.axis_P), LinY | LinZ | AngY | AngZ), parent, child);
      default: return this.addUniversal(joint, add, parent, child);
    }
  }

  /** Adds a universal joint as two hinges with a light body between them. */
  addUniversal(joint, add, parent, child) {
    const { JointData } = this.rapier, { start } = this.scene.bodies[joint.child];
    const between = this.world.createRigidBody(this.description({ ...light, start }));
    add(JointData.revolute(vector(joint.anchor_P), vector(joint.anchor_C), vector(joint.axis_P)), parent, between);
    add(JointData.revolute(vector(joint.anchor_C), vector(joint.anchor_C), vector(joint.axis_C)), between, child);
  }

  /** Takes the step from n h to (n + 1) h. */
  step(n) {
    this.scene.bodies.forEach((body, i) => {
      if (!body.coupling) return;
      const D = sample(this.scene, i, (n + 1) * this.h, this.h, this.variant.target);
      const { f, tau } = couplingForce(body, this.state(i), D, this.h, true);
      this.push(this.bodies[i], f, tau);
    });
    this.world.step();
  }

  /** Applies the impulse of a force before the step; links of a multibody receive forces alone. */
  push(body, f, tau) {
    if (this.variant.reduced && this.scene.joints.length) {
      body.resetForces(true);
      body.resetTorques(true);
      body.addForce(vector(f), true);
      body.addTorque(vector(tau), true);
    } else {
      body.applyImpulse(vector(scale(this.h, f)), true);
      body.applyTorqueImpulse(vector(scale(this.h, tau)), true);
    }
  }

  state(i) {
    const body = this.bodies[i];
    return { ...this.pose(i), v: list(body.linvel()), w: list(body.angvel()) };
  }

  look() {}

  pose(i) {
    const { w, x, y, z } = this.bodies[i].rotation();
    return { p: list(this.bodies[i].translation()), q: [w, x, y, z] };
  }

  free() {
    this.world.free();
  }
}

const target = { share: 1, mean: true };
const tight = { lengthUnit: 0.1, contact_natural_frequency: 200 };  // m, Hz: for tools of centimetres
const settings = [
  { name: 'Rapier', reduced: false, target, parameters: tight },
  { name: 'Rapier multibody', reduced: true, target, parameters: tight },
];

const isChain = ({ joints }) => joints.length > 0 && joints.every(({ type }) => type === 'ball');

export async function variants({ default: rapier }) {
  await rapier.init();
  return settings.map((variant) => ({
    ...variant,
    can: (scene) => !variant.reduced || isChain(scene),
    make: (scene, h) => new Run(rapier, scene, h, variant),
  }));
}
