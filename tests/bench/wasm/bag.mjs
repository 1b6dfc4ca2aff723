// The bag of endobag.toml with a bar pressed into it: where its nodes rest, and how deep they are in the bar.
import { median } from './error.mjs';
import { norm, sub } from './math.mjs';

/** Returns the centre of the bar, which moves along x for as long as the press takes and then rests. */
export function barAt({ bar: { start, press, time } }, t) {
  return [start - (press / 2) * (1 - Math.cos((Math.PI * Math.min(t, time)) / time)), 0, 0];
}

/** Returns how deep a node is in the bar, whose axis is y, m; negative outside. */
export function depthOf({ bar, radius }, centre, p) {
  const on = [centre[0], Math.min(Math.max(p[1], -bar.half_length), bar.half_length), centre[2]];
  return bar.radius + radius - norm(sub(p, on));
}

/** Runs the bag in an engine. Returns {error, depth, usPerStep}: the farthest node from the reference at rest. */
export function bagOf(variant, bag) {
  const run = variant.makeBag(bag), times = [], steps = Math.round(bag.duration / bag.h);
  for (let n = 0; n < steps; ++n) {
    const start = performance.now();
    run.step(n);
    times.push(1e3 * (performance.now() - start));
  }
  let error = 0, depth = -Infinity;
  bag.rest.forEach((rest, n) => {
    error = Math.max(error, norm(sub(run.node(n), rest)));
    depth = Math.max(depth, depthOf(bag, barAt(bag, steps * bag.h), run.node(n)));
  });
  run.free();
  const isFinite = Number.isFinite(error) && Number.isFinite(depth);
  return { error: isFinite ? error : Infinity, depth: isFinite ? depth : Infinity, usPerStep: median(times) };
}
