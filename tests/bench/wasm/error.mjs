// Error of an engine on a scene with reference poses, and time per step.
import { angleBetween, norm, sub } from './math.mjs';

const comparedEvery = 4e-3;  // s: instants of the scene file

/** Runs a variant once. Returns {position, rotation, usPerStep}; errors are infinite once it fails. */
export function errorsOf(variant, scene, h) {
  const run = variant.make(scene, h), every = Math.round(comparedEvery / h);
  const errors = { position: 0, rotation: 0 }, times = [];
  for (let n = 0; n < Math.round(scene.duration / h); ++n) {
    const start = performance.now();
    run.step(n);
    times.push(1e3 * (performance.now() - start));
    if ((n + 1) % every !== 0) continue;
    const instant = scene.instants[(n + 1) / every];
    if (!instant || instant.t < scene.from) continue;
    run.look();
    instant.poses.forEach((exact, i) => {
      const { p, q } = run.pose(i);
      errors.position = Math.max(errors.position, norm(sub(p, exact.p)));
      errors.rotation = Math.max(errors.rotation, angleBetween(q, exact.q));
    });
    if (!(errors.position < failed)) return { position: Infinity, rotation: Infinity, usPerStep: median(times) };
  }
  run.free();
  return { ...errors, usPerStep: median(times) };
}

const failed = 0.1;  // m

export function median(values) {
  return [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
}
