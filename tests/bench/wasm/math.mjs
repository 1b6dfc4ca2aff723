// Vectors [x, y, z] and quaternions [w, x, y, z], as arrays.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (s, a) => [s * a[0], s * a[1], s * a[2]];
export const times = (a, b) => [a[0] * b[0], a[1] * b[1], a[2] * b[2]];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const norm = (a) => Math.hypot(...a);

export const conjugate = (q) => [q[0], -q[1], -q[2], -q[3]];
export const multiply = (a, b) => [
  a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
  a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
  a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
  a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
];
export const about = (axis, angle) => [Math.cos(angle / 2), ...scale(Math.sin(angle / 2), axis)];

/** Returns q a: a vector in the axes of q, in those of the world. */
export function rotate(q, a) {
  const u = [q[1], q[2], q[3]];
  const t = scale(2, cross(u, a));
  return add(a, add(scale(q[0], t), cross(u, t)));
}

/** Returns the rotation vector of q, of length 0 to pi. */
export function rotationVector(q) {
  const u = q[0] < 0 ? [-q[1], -q[2], -q[3]] : [q[1], q[2], q[3]];
  const s = norm(u);
  return s < 1e-12 ? scale(2, u) : scale((2 * Math.atan2(s, Math.abs(q[0]))) / s, u);
}

export function angleBetween(a, b) {
  return norm(rotationVector(multiply(conjugate(a), b)));
}

export const X = [1, 0, 0], Y = [0, 1, 0], Z = [0, 0, 1];
export const identity = [1, 0, 0, 0];
