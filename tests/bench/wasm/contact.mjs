// Penetration and jitter of an engine on S2, by the measures of tests/bench/contact_quality.h.
import { add, rotate } from './math.mjs';
import { median } from './error.mjs';

const step = 1e-3, settled = 3;  // s

/** Returns the mean depth of the spheres in the plane z = 0. */
function depthOf({ centres, radius }, { p, q }) {
  let sum = 0;
  for (const c of centres) sum += radius - add(p, rotate(q, c))[2];
  return sum / centres.length;
}

/** Runs a variant on S2 for its duration. Returns {depth, jitter, usPerStep}; infinite if it fails. */
export function contactOf(variant, scene) {
  const run = variant.make(scene, step), depths = [], times = [];
  for (let n = 0; n < Math.round(scene.duration / step); ++n) {
    const start = performance.now();
    run.step(n);
    times.push(1e3 * (performance.now() - start));
    run.look();
    depths.push(depthOf(scene.contact, run.pose(0)));
    if (!(Math.abs(depths[n]) < 1)) return { depth: Infinity, jitter: Infinity, usPerStep: median(times) };
  }
  run.free();
  const first = Math.round(settled / step), num = depths.length - first;
  let depth = 0, square = 0;
  for (let n = first; n < depths.length; ++n) {
    depth += depths[n] / num;
    square += (depths[n] - depths[n - 1]) ** 2 / num;
  }
  return { depth, jitter: Math.sqrt(square), usPerStep: median(times) };
}
