// A scene as the study writes it: bodies, joints, couplings, and reference poses at given instants.
import { readFileSync } from 'node:fs';
import { angleBetween, norm, sub } from './math.mjs';
import { motionOf } from './motion.mjs';

const sameTarget = 1e-9;  // m, rad, m/s, rad/s: of the study's target and that of motion.mjs

/** Reads a scene file. Throws if its targets are not those of motion.mjs. */
export function load(file) {
  const scene = JSON.parse(readFileSync(file, 'utf8'));
  scene.motion = motionOf(scene.name);
  for (const { t, targets } of scene.instants)
    targets.forEach((target, body) => {
      const own = scene.motion(t, body);
      const apart = Math.max(norm(sub(own.p, target.p)), angleBetween(own.q, target.q),
        norm(sub(own.v, target.v)), norm(sub(own.w, target.w)));
      if (!(apart < sameTarget))
        throw new Error(`${file}: the target of body ${body} at ${t} s differs from motion.mjs by ${apart}`);
    });
  return scene;
}

/** Returns the target of a body for the step that ends at t.
 * share: instant of the sample within the step, 0 start to 1 end; mean: true for the mean velocity of the step. */
export function sample(scene, body, t, h, { share, mean }) {
  const at = scene.motion(t - (1 - share) * h, body);
  if (!mean) return at;
  const half = h / 2;
  const before = scene.motion(t - 2 * half, body), after = scene.motion(t, body);
  const middle = scene.motion(t - half, body);
  return { ...at, v: [0, 1, 2].map((i) => (after.p[i] - before.p[i]) / h), w: middle.w };
}
