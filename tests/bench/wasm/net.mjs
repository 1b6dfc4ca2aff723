// Stretch of the hanging net S6 at rest, by the measure of tests/bench/net_contest.h, without its ball.
import { median } from './error.mjs';
import { norm, sub } from './math.mjs';

/** Returns the springs of the net as pairs of nodes. */
export function springsOf({ across, down }) {
  const springs = [];
  for (let n = 0; n < across * down; ++n) {
    if ((n % across) + 1 < across) springs.push([n, n + 1]);
    if (n + across < across * down) springs.push([n, n + across]);
  }
  return springs;
}

export const isHeld = ({ across }, n) => n < across;

export function startOf({ across, spacing }, n) {
  return [((n % across) - (across - 1) / 2) * spacing, 0, -Math.floor(n / across) * spacing];
}

/** Returns the largest difference of a hanging spring's strain from that at rest. */
function stretchError(net, nodeAt) {
  let worst = 0;
  for (let n = 0; n + net.across < net.across * net.down; ++n) {
    const below = net.down - 1 - Math.floor(n / net.across);
    const strain = (below * net.m * net.gravity) / (net.k * net.spacing);
    const length = norm(sub(nodeAt(n + net.across), nodeAt(n)));
    worst = Math.max(worst, Math.abs(length / net.spacing - 1 - strain));
  }
  return worst;
}

/** Runs a net of an engine. Returns {stretch, usPerStep}. */
export function stretchOf(variant, net) {
  const run = variant.makeNet(net), times = [];
  for (let n = 0; n < Math.round(net.duration / net.h); ++n) {
    const start = performance.now();
    run.step();
    times.push(1e3 * (performance.now() - start));
  }
  const stretch = stretchError(net, (n) => run.node(n));
  run.free();
  return { stretch: Number.isFinite(stretch) ? stretch : Infinity, usPerStep: median(times) };
}
