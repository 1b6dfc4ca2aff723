// MuJoCo: official WASM build, double precision.
import { add, conjugate, cross, dot, rotate, scale, sub } from './math.mjs';
import { modelOf } from './mujoco_model.mjs';
import { MujocoBag } from './mujoco_bag.mjs';
import { MujocoNet } from './mujoco_net.mjs';
import { sample } from './scene.mjs';

export const packageName = '@mujoco/mujoco';

// Instant and velocity of the target that are best on S1.
const held = { share: 0, mean: false }, end = { share: 1, mean: false }, mean = { share: 1, mean: true };
const manyBodies = 10;  // scenes with as many are for the integrators marked 'many' alone
const middle = { share: 0.5, mean: false };
const integrators = [
  { name: 'MuJoCo Euler', integrator: 'Euler', target: held },
  { name: 'MuJoCo implicitfast', integrator: 'implicitfast', target: held, many: true },
  { name: 'MuJoCo discrete', integrator: 'discrete', target: end, many: true },
  { name: 'MuJoCo discrete (mean velocity)', integrator: 'discrete', target: mean },
  { name: 'MuJoCo RK4 (mid-step target)', integrator: 'RK4', target: middle },
];

class Run {
  constructor(mj, scene, h, variant) {
    this.scene = scene;
    this.h = h;
    this.target = variant.target;
    this.isFree = scene.joints.length === 0;
    this.model = mj.MjModel.from_xml_string(modelOf(scene, {
      h, integrator: variant.integrator, solref: '0.02 0.5', solimp: '0.9 0.95 0.001', isFree: this.isFree,
    }));
    this.data = new mj.MjData(this.model);
    this.advance = () => mj.mj_step(this.model, this.data);
    this.kinematics = () => mj.mj_kinematics(this.model, this.data);
    const { model, data } = this;
    this.view = {
      qpos: data.qpos, qvel: data.qvel, spring: model.qpos_spring, applied: data.qfrc_applied, control: data.ctrl,
      mocapPos: data.mocap_pos, mocapQuat: data.mocap_quat, xpos: data.xpos, xquat: data.xquat, xvel: data.cvel,
    };
    this.start();
    mj.mj_forward(model, data);
  }

  start() {
    const { qpos, qvel } = this.view;
    if (this.isFree) {
      this.scene.bodies.forEach(({ start: { p, q, v, w } }, i) => {
        qpos.set([...p, ...q], 7 * i);
        qvel.set([...v, ...rotate(conjugate(q), w)], 6 * i);
      });
      return;
    }
    let at = 0;
    for (const joint of this.scene.joints) {
      const rates = jointRates(this.scene, joint);
      qvel.set(rates, at);
      at += rates.length;
    }
  }

  /** Takes the step from n h to (n + 1) h. */
  step(n) {
    const t = (n + 1) * this.h, { view } = this;
    this.scene.bodies.forEach(({ coupling: c }, i) => {
      if (!c) return;
      const D = sample(this.scene, i, t, this.h, this.target);
      if (this.isFree) {
        const inBody = (a) => rotate(conjugate(view.qpos.slice(7 * i + 3, 7 * i + 7)), a);
        view.spring.set([...D.p, ...D.q], 7 * i);
        view.applied.set([...scale(c.g, D.v), ...scale(c.g_r, inBody(D.w))], 6 * i);
      } else {
        // The rotation of the site is in the axes of the mocap body; its velocity is fed forward.
        view.mocapPos.set(D.p, 3 * i);
        view.mocapQuat.set(D.q, 4 * i);
        const inTarget = (a) => rotate(conjugate(D.q), a);
        view.control.set([...scale(c.g / c.k, inTarget(D.v)), ...scale(c.g_r / c.k_r, inTarget(D.w))], 6 * i);
      }
    });
    this.advance();
  }

  /** Returns the pose of a body after the step. */
  pose(i) {
    const { qpos, xpos, xquat } = this.view;
    if (this.isFree) return { p: [...qpos.slice(7 * i, 7 * i + 3)], q: [...qpos.slice(7 * i + 3, 7 * i + 7)] };
    return { p: [...xpos.slice(3 * i + 3, 3 * i + 6)], q: [...xquat.slice(4 * i + 4, 4 * i + 8)] };
  }

  /** Computes the poses after the last step, before pose(). */
  look() {
    this.kinematics();
  }

  free() {
    this.data.delete();
    this.model.delete();
  }
}

/** Returns the rates of a joint's coordinates at the start. */
function jointRates(scene, joint) {
  const still = { p: [0, 0, 0], q: [1, 0, 0, 0], v: [0, 0, 0], w: [0, 0, 0] };
  const P = joint.parent === null ? still : scene.bodies[joint.parent].start, C = scene.bodies[joint.child].start;
  const w = sub(C.w, P.w), axis = rotate(P.q, joint.axis_P);
  if (joint.type === 'ball') return rotate(conjugate(C.q), w);
  if (joint.type === 'hinge') return [dot(w, axis)];
  if (joint.type === 'universal') return [dot(w, axis), dot(w, rotate(C.q, joint.axis_C))];
  const lever = add(sub(C.p, P.p), rotate(C.q, joint.anchor_C));
  const v = sub(add(C.v, cross(C.w, rotate(C.q, joint.anchor_C))), add(P.v, cross(P.w, lever)));
  return [dot(v, axis), dot(w, axis)];
}

export async function variants({ default: load }) {
  const mj = await load({ print: () => {}, printErr: () => {} });
  return integrators.map((variant) => ({
    ...variant,
    can: (scene) => variant.many || scene.bodies.length < manyBodies,
    make: (scene, h) => new Run(mj, scene, h, variant),
    makeNet: variant.many && ((net) => new MujocoNet(mj, net, variant.integrator)),
    makeBag: variant.many && ((bag) => new MujocoBag(mj, bag, variant.integrator)),
  }));
}
