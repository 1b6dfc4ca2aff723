// Targets of the scenes in closed form: pose and velocity {p, q, v, w} of a body's target at a time.
// The scene file has samples of the study's own targets, with which load() of scene.mjs compares these.
import { X, Y, Z, about, add, cross, identity, multiply, rotate, scale } from './math.mjs';

const degree = Math.PI / 180;

/** Returns [value, rate] of size sin(2 pi frequency t + phase). */
function sine(t, size, frequency, phase = 0) {
  const w = 2 * Math.PI * frequency;
  return [size * Math.sin(w * t + phase), size * w * Math.cos(w * t + phase)];
}
const product = (a, b) => [a[0] * b[0], a[1] * b[0] + a[0] * b[1]];

/** Smoothed step from 0 to 1 in the first second, a cubic. */
function eased(t) {
  if (t <= 0) return [0, 0];
  return t >= 1 ? [1, 0] : [t * t * (3 - 2 * t), 6 * t * (1 - t)];
}

const origin = { p: [0, 0, 0], q: identity, v: [0, 0, 0], w: [0, 0, 0] };

/** Turns a frame about one of its own axes by [angle, rate]. */
function turned(frame, axis, [angle, rate]) {
  return {
    p: frame.p, v: frame.v,
    w: add(frame.w, rotate(frame.q, scale(rate, axis))),
    q: multiply(frame.q, about(axis, angle)),
  };
}

/** Moves the origin to a point of the frame, which slides in it at v. */
function moved(frame, p, v = [0, 0, 0]) {
  const lever = rotate(frame.q, p);
  return {
    q: frame.q, w: frame.w, p: add(frame.p, lever),
    v: add(add(frame.v, cross(frame.w, lever)), rotate(frame.q, v)),
  };
}

function placed(x, y, z) {
  return { ...origin, p: [x[0], y[0], z[0]], v: [x[1], y[1], z[1]] };
}

function s1(t) {
  const at = placed(sine(t, 0.1, 0.5), sine(t, 0.08, 0.7, 0.5), sine(t, 0.06, 1.1, 1.1));
  const yawed = turned(at, Z, sine(t, 1, 0.4, 0.7));
  return turned(turned(yawed, Y, sine(t, 0.6, 0.9, 0.3)), X, sine(t, 0.8, 0.6));
}

function s2(t) {
  const u = t - 1.5, drag = eased(u), press = eased(t);
  const at = placed(product(drag, sine(u, 0.1, 0.5)), product(drag, sine(u, 0.08, 0.3)),
    [0.07 * (1 - press[0]), -0.07 * press[1]]);
  return turned(turned(at, Z, product(drag, sine(u, 0.5, 0.4))), Y, [Math.PI / 2, 0]);
}

const hingeZ = -0.175, jawLength = 0.01;  // m, from the centres of tube and jaw

function s3(t, body) {
  const trocar = turned(turned(origin, X, sine(t, 30 * degree, 1)), Y, sine(t, 30 * degree, 0.8, 0.9));
  if (body === 0) return trocar;
  const [slide, rate] = sine(t, 0.04, 0.5, 0.4);
  const tube = turned(moved(trocar, [0, 0, 0.025 + slide], [0, 0, rate]), Z, sine(t, 60 * degree, 0.7, 1.3));
  if (body === 1) return tube;
  const side = body === 2 ? 1 : -1, [angle, angleRate] = sine(t, side * 20 * degree, 1.2, -Math.PI / 2);
  return moved(turned(moved(tube, [0, 0, hingeZ]), X, [side * 20 * degree + angle, angleRate]), [0, 0, -jawLength]);
}

function s4(t) {
  const [x, xRate] = sine(t, -0.22, 0.2, Math.PI / 2), [lift, liftRate] = sine(t, -0.004, 0.3, Math.PI / 2);
  return turned(placed([x, xRate], sine(t, 0.035, 0.37), [0.011 + lift, liftRate]), Z, sine(t, 0.6, 0.25));
}

/** Returns the target (t, body) of a scene by its name up to a slash; undefined if nothing drives its bodies. */
export function motionOf(scene) {
  return { S1: s1, S2: s2, S3: s3, S4: s4 }[scene.split('/')[0]];
}
