// The net S6 in MuJoCo: particles on three slides each, springs that are spatial tendons.
import { isHeld, springsOf, startOf } from './net.mjs';

function modelOf(net, integrator) {
  const nodes = [], num = net.across * net.down;
  for (let n = 0; n < num; ++n) {
    const slides = ['1 0 0', '0 1 0', '0 0 1'].map((a) => `<joint type="slide" axis="${a}" damping="${net.g_air}"/>`);
    const inertia = `<inertial pos="0 0 0" mass="${net.m}" diaginertia="1e-12 1e-12 1e-12"/>`;
    const moving = isHeld(net, n) ? '' : slides.join('') + inertia;
    nodes.push(`<body pos="${startOf(net, n).join(' ')}">${moving}<site name="n${n}"/></body>`);
  }
  const tendons = springsOf(net).map(([i, j]) =>
    `<spatial stiffness="${net.k}" damping="${net.g}" springlength="${net.spacing}">` +
    `<site site="n${i}"/><site site="n${j}"/></spatial>`);
  return `<mujoco><compiler boundmass="0" boundinertia="0"/><size memory="400M"/>
<option timestep="${net.h}" gravity="0 0 ${-net.gravity}" integrator="${integrator}" jacobian="sparse"/>
<worldbody>${nodes.join('\n')}</worldbody><tendon>${tendons.join('\n')}</tendon></mujoco>`;
}

export class MujocoNet {
  constructor(mj, net, integrator) {
    Object.assign(this, { mj, net, model: mj.MjModel.from_xml_string(modelOf(net, integrator)) });
    this.data = new mj.MjData(this.model);
  }

  step() {
    this.mj.mj_step(this.model, this.data);
  }

  node(n) {
    const start = startOf(this.net, n), { qpos } = this.data, at = 3 * (n - this.net.across);
    return isHeld(this.net, n) ? start : start.map((x, i) => x + qpos[at + i]);
  }

  free() {
    this.data.delete();
    this.model.delete();
  }
}
