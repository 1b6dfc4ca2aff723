// Coupling of engines that take forces alone: forces of the end of the step, for the body without its joints.
// With M the mass or moment, k and g the spring's: (M + h g + h^2 k) a = k (error - h rate) + g (rate error).
import { conjugate, cross, multiply, rotate, rotationVector, sub, times } from './math.mjs';

/** Returns {f, tau}, world axes. x: {p, q, v, w} of the body at the start of the step. D: target of its end.
 * addsGyroscopic: true for engines that add the gyroscopic torque -w x I w themselves. */
export function couplingForce({ m, I, coupling: c }, x, D, h, addsGyroscopic) {
  const e = sub(D.p, x.p), inBody = (a) => rotate(conjugate(x.q), a);
  const f = [0, 1, 2].map((i) =>
    (m / (m + h * c.g + h * h * c.k)) * (c.k * (e[i] - h * x.v[i]) + c.g * (D.v[i] - x.v[i])));
  const turn = inBody(rotationVector(multiply(D.q, conjugate(x.q))));
  const w = inBody(x.w), wD = inBody(D.w), spin = cross(w, times(I, w));
  const tau = [0, 1, 2].map((i) => {
    const torque = c.k_r * (turn[i] - h * w[i]) + c.g_r * (wD[i] - w[i]) - spin[i];
    return (I[i] / (I[i] + h * c.g_r + h * h * c.k_r)) * torque + (addsGyroscopic ? spin[i] : 0);
  });
  return { f, tau: rotate(x.q, tau) };
}
