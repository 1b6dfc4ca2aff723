// Distance of an engine from the target of S1 with stiffer springs, at equal damping ratio.
import { norm, sub } from './math.mjs';

const failed = 0.01;  // m, thirty times the distance of the exact solution at 1e3 N/m

/** Returns the scene with its coupling stiffened to k N/m. */
export function stiffened(scene, k) {
  const bodies = scene.bodies.map((body) => {
    const c = body.coupling, factor = k / c.k, root = Math.sqrt(factor);
    return { ...body, coupling: { k, k_r: c.k_r * factor, g: c.g * root, g_r: c.g_r * root } };
  });
  return { ...scene, bodies };
}

/** Returns the largest distance from the target, m; infinite if the engine fails. */
export function distanceOf(variant, scene, h, duration) {
  const run = variant.make(scene, h);
  let worst = 0;
  for (let n = 0; n < Math.round(duration / h); ++n) {
    run.step(n);
    run.look();
    const distance = norm(sub(run.pose(0).p, scene.motion((n + 1) * h, 0).p));
    if (!(distance < failed)) return Infinity;
    worst = Math.max(worst, distance);
  }
  run.free();
  return worst;
}
