// Overlap and speed of the bricks of S4, by the measures of tests/bench/contact_quality.h.
import { median } from './error.mjs';
import { X, Y, Z, cross, dot, norm, rotate, sub } from './math.mjs';

const step = 1e-3, numInstants = 200, ejected = 10;  // s, -, m

/** Returns the depth of two equal boxes in each other by the separating-axis test; 0 if they are apart. */
export function overlapOf(half, a, b) {
  const d = sub(b.p, a.p);
  if (norm(d) > 2 * norm(half)) return 0;
  const axesA = [X, Y, Z].map((e) => rotate(a.q, e)), axesB = [X, Y, Z].map((e) => rotate(b.q, e));
  let least = Infinity;
  for (const axis of [...axesA, ...axesB, ...axesA.flatMap((u) => axesB.map((v) => cross(u, v)))]) {
    const length = norm(axis);
    if (length < 1e-6) continue;  // edges of one direction
    let reach = 0;
    for (let i = 0; i < 3; ++i) reach += half[i] * (Math.abs(dot(axesA[i], axis)) + Math.abs(dot(axesB[i], axis)));
    least = Math.min(least, (reach - Math.abs(dot(d, axis))) / length);
    if (least <= 0) return 0;
  }
  return least;
}

function worstOverlap(half, poses) {
  let worst = 0;
  for (let i = 0; i < poses.length; ++i)
    for (let j = 0; j < i; ++j) worst = Math.max(worst, overlapOf(half, poses[i], poses[j]));
  return worst;
}

/** Runs a variant on S4. Returns {overlap, median, usPerStep, p99}; overlaps are infinite if a brick is ejected. */
export function pileOf(variant, scene) {
  const run = variant.make(scene, step), overlaps = [], times = [], num = Math.round(scene.duration / step);
  const every = Math.max(Math.floor(num / numInstants), 1);
  let failed = false;
  for (let n = 0; n < num && !failed; ++n) {
    const start = performance.now();
    run.step(n);
    times.push(1e3 * (performance.now() - start));
    if ((n + 1) % every !== 0) continue;
    run.look();
    const poses = scene.bodies.map((_, i) => run.pose(i));
    failed = !poses.every(({ p }) => norm(p) < ejected);
    overlaps.push(worstOverlap(scene.contact.half_extents, poses));
  }
  run.free();
  times.sort((x, y) => x - y);
  const worst = failed ? [Infinity, Infinity] : [Math.max(...overlaps), median(overlaps)];
  const p99 = times[Math.floor(0.99 * times.length)];
  return { overlap: worst[0], median: worst[1], usPerStep: median(times), p99 };
}
