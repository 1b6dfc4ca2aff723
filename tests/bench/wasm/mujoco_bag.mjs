// The bag of endobag.toml in MuJoCo: nodes on three slides each, whose springs are the anchors, springs that are
// spatial tendons, and the bar as a mocap body. Nodes touch the bar alone, without friction.
import { barAt } from './bag.mjs';

function modelOf(bag, integrator) {
  const { bar, radius } = bag;
  const nodes = bag.nodes.map(({ m, p, k, g }, n) => {
    const slides = ['1 0 0', '0 1 0', '0 0 1'].map((a) =>
      `<joint type="slide" axis="${a}" stiffness="${k}" damping="${g}"/>`);
    return `<body pos="${p.join(' ')}">${slides.join('')}` +
      `<inertial pos="0 0 0" mass="${m}" diaginertia="1e-12 1e-12 1e-12"/>` +
      `<geom type="sphere" size="${radius}" contype="1" conaffinity="2"/><site name="n${n}"/></body>`;
  });
  const tendons = bag.springs.map(({ i, j, k, g, l }) =>
    `<spatial stiffness="${k}" damping="${g}" springlength="${l}"><site site="n${i}"/><site site="n${j}"/></spatial>`);
  return `<mujoco><compiler boundmass="0" boundinertia="0"/><size memory="400M"/>
<option timestep="${bag.h}" gravity="0 0 0" integrator="${integrator}" jacobian="sparse"/>
<default><geom condim="1" solref="0.002 1" solimp="0.9 0.95 0.001"/></default>
<worldbody><body mocap="true" pos="${barAt(bag, 0).join(' ')}"><geom type="capsule" size="${bar.radius}"
 fromto="0 ${-bar.half_length} 0 0 ${bar.half_length} 0" contype="2" conaffinity="1"/></body>
${nodes.join('\n')}</worldbody><tendon>${tendons.join('\n')}</tendon></mujoco>`;
}

export class MujocoBag {
  constructor(mj, bag, integrator) {
    Object.assign(this, { mj, bag, model: mj.MjModel.from_xml_string(modelOf(bag, integrator)) });
    this.data = new mj.MjData(this.model);
  }

  step(n) {
    this.data.mocap_pos.set(barAt(this.bag, (n + 1) * this.bag.h));
    this.mj.mj_step(this.model, this.data);
  }

  node(n) {
    const { qpos } = this.data;
    return this.bag.nodes[n].p.map((x, i) => x + qpos[3 * n + i]);
  }

  free() {
    this.data.delete();
    this.model.delete();
  }
}
