// MuJoCo's model of a scene (MJCF): free bodies on three slides and a ball, articulated ones in a tree.
import { X, Y, Z, conjugate, multiply, rotate, sub } from './math.mjs';

const text = (a) => a.map((x) => x.toPrecision(17)).join(' ');

/** Joints of a body without a joint: their springs are the coupling, springref its target. */
function freeJoints({ coupling: c }) {
  const spring = c ? `stiffness="${c.k}" damping="${c.g}"` : '';
  const turn = c ? `stiffness="${c.k_r}" damping="${c.g_r}"` : '';
  return [X, Y, Z].map((axis) => `<joint type="slide" axis="${text(axis)}" ${spring}/>`).join('') +
    `<joint type="ball" ${turn}/>`;
}

/** Joints of a child, in its axes at the start, where their coordinates are zero. q: of the child in its parent. */
function childJoints(joint, q) {
  const pos = `pos="${text(joint.anchor_C)}"`, axis = (a) => `axis="${text(a)}" ${pos}`;
  const own = rotate(conjugate(q), joint.axis_P);
  switch (joint.type) {
    case 'universal': return `<joint ${axis(own)}/><joint ${axis(joint.axis_C)}/>`;
    case 'cylindrical': return `<joint type="slide" ${axis(own)}/><joint ${axis(own)}/>`;
    case 'hinge': return `<joint ${axis(own)}/>`;
    case 'ball': return `<joint type="ball" ${pos}/>`;
    default: throw new Error(`mujoco_model.mjs has no joint ${joint.type}`);
  }
}

function solver({ contact }, option) {
  return `condim="3" friction="${contact.mu} 0 0" solref="${option.solref}" solimp="${option.solimp}"`;
}

function shapes(scene, option) {
  const { contact } = scene;
  if (!contact) return '';
  if (contact.half_extents) return `<geom type="box" size="${text(contact.half_extents)}" ${solver(scene, option)}/>`;
  return contact.centres.map((c) =>
    `<geom size="${contact.radius}" pos="${text(c)}" ${solver(scene, option)}/>`).join('');
}

/** Returns the body with its children. */
function body(scene, i, option) {
  const { m, I, start } = scene.bodies[i], joint = scene.joints.find((j) => j.child === i);
  const parent = joint && joint.parent !== null ? scene.bodies[joint.parent].start : { p: [0, 0, 0], q: [1, 0, 0, 0] };
  // Slides measure from the origin, so that their springref is the target's position.
  const p = option.isFree ? [0, 0, 0] : rotate(conjugate(parent.q), sub(start.p, parent.p));
  const q = option.isFree ? [1, 0, 0, 0] : multiply(conjugate(parent.q), start.q);
  const children = scene.joints.filter((j) => j.parent === i).map((j) => body(scene, j.child, option)).join('');
  const joints = joint ? childJoints(joint, q) : freeJoints(scene.bodies[i]);
  return `<body name="b${i}" pos="${text(p)}" quat="${text(q)}">${joints}` +
    `<inertial pos="0 0 0" mass="${m}" diaginertia="${text(I)}"/><site name="s${i}"/>` +
    `${shapes(scene, option)}${children}</body>\n`;
}

/** Actuators between a body's site and that of a mocap body at its target: force k (u - length) - g rate. */
function actuators({ coupling: c }, i) {
  const one = (axis, k, g) => `<general site="s${i}" refsite="t${i}" gear="${axis}" gainprm="${k}" ` +
    `biastype="affine" biasprm="0 ${-k} ${-g}"/>`;
  return ['1 0 0', '0 1 0', '0 0 1'].map((a) => one(`${a} 0 0 0`, c.k, c.g)).join('') +
    ['1 0 0', '0 1 0', '0 0 1'].map((a) => one(`0 0 0 ${a}`, c.k_r, c.g_r)).join('\n');
}

/** option: integrator, h, solref, solimp; isFree: true if no body has a joint. */
export function modelOf(scene, option) {
  const all = scene.bodies.map((_, i) => i);
  const roots = all.filter((i) => !scene.joints.some((j) => j.child === i && j.parent !== null));
  const coupled = option.isFree ? [] : all.filter((i) => scene.bodies[i].coupling);
  return `<mujoco><compiler autolimits="true" boundmass="0" boundinertia="0"/>
<option timestep="${option.h}" integrator="${option.integrator}" gravity="${text(scene.gravity)}" cone="elliptic"/>
<worldbody>${scene.contact ? `<geom type="plane" size="2 2 1" ${solver(scene, option)}/>` : ''}
${roots.map((i) => body(scene, i, option)).join('')}
${coupled.map((i) => `<body name="m${i}" mocap="true"><site name="t${i}"/></body>`).join('\n')}
</worldbody>
${coupled.length ? `<actuator>${coupled.map((i) => actuators(scene.bodies[i], i)).join('\n')}</actuator>` : ''}
</mujoco>`;
}
