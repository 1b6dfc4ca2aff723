// Plots over time beside the picture.
import uPlot from "uplot";
import { feedbackForce, targetPose, bodyPose } from "./wire.js";

const SPAN_S = 20, REDRAW_MS = 100;
const length = (v) => Math.hypot(v[0], v[1], v[2]);

// Returns the largest displayed force of all driven bodies, N.
export function shownForce(frame) {
  let most = length(frame.handForce);
  for (let i = 0; i < frame.numDriven; ++i) most = Math.max(most, length(feedbackForce(frame, i)));
  return most;
}
export function divergence(frame, driven) {
  let most = 0;
  driven.forEach((body, i) => {
    const a = targetPose(frame, i), b = bodyPose(frame, body);
    if (frame.held < 0 || frame.held === body) most = Math.max(most, Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
  });
  return most;
}

export const RUN_STRIPS = [
  { title: "force to the hand, N", series: [["#d5452c", (f) => shownForce(f)]] },
  { title: "tool from device, mm", series: [["#e08a1e", (f, driven) => 1e3 * divergence(f, driven)]] },
  { title: "energy, J (dashed: balance)", series: [["#3b7dd8", (f) => f.energy], ["#8a93a3", (f) => f.balance, [4, 3]]] },
  { title: "step, us (dashed: wake-up)", series: [["#2c9c5a", (f) => f.stepUs || null], ["#8a93a3", (f) => f.wakeUs || null, [4, 3]]] },
];

// Returns a short text of a number on an axis, so that all of them fit.
const short = (x) => x === 0 ? "0" : Math.abs(x) >= 1e5 || Math.abs(x) < 1e-3 ? x.toExponential(1).replace("e+", "e") : String(Number(x.toPrecision(4)));
// Returns the width of an axis with these texts, CSS pixels.
const axisWidth = (texts) => 12 + 6 * Math.max(1, ...(texts ?? []).map((text) => text.length));

// Returns the ends of an axis: with a margin, and not closer than the numbers are exact.
function rangeOf(low, high) {
  if (!Number.isFinite(low) || !Number.isFinite(high)) return [0, 1];
  const margin = Math.max(0.05 * (high - low), 1e-4 * Math.max(Math.abs(low), Math.abs(high)), 1e-9);
  return [low >= 0 && low < margin ? 0 : low - margin, high + margin];
}

export class Strips {
  // strips: titles, and series of colour, value(frame, driven) and dash
  constructor(parent, strips) {
    Object.assign(this, { parent, strips, plots: [] });  // a plot for each strip that has had a value
    this.clear();
  }
  remove() {
    for (const plot of this.plots) plot?.destroy();
    this.plots = [];
  }
  clear() {
    this.times = [];
    this.columns = this.strips.map((strip) => strip.series.map(() => []));
    this.marker = null;
    this.changed = true;
  }
  add(frame, driven) {
    const last = this.times.at(-1);
    if (last !== undefined && frame.t < last) this.clear();  // another run
    if (frame.t === last) return;
    this.times.push(frame.t);
    this.strips.forEach((strip, i) => strip.series.forEach(([, value], k) => this.columns[i][k].push(value(frame, driven))));
    this.changed = true;
  }
  trim() {
    const from = this.times.findIndex((t) => t >= this.times.at(-1) - SPAN_S);
    if (from < 200) return;
    this.times.splice(0, from);
    for (const columns of this.columns) for (const column of columns) column.splice(0, from);
  }
  mark(t) {
    this.marker = t;
    this.changed = true;
  }
  draw(now, whole) {
    if (!this.changed || now - (this.drawn ?? 0) < REDRAW_MS || this.times.length < 2) return;
    this.drawn = now;
    this.changed = false;
    if (!whole) this.trim();
    this.columns.forEach((columns, i) => {
      if (columns.some((column) => column.some((value) => value !== null))) this.plots[i] ??= this.plot(this.strips[i]);
    });
    const end = this.times.at(-1), begin = whole ? this.times[0] : Math.max(this.times[0], end - SPAN_S);
    this.plots.forEach((plot, i) => plot?.setData([this.times, ...this.columns[i]], false));
    this.plots.forEach((plot) => plot?.batch(() => { plot.setScale("x", { min: begin, max: end }); plot.redraw(false, true); }));
  }
  plot(strip) {
    const style = getComputedStyle(document.documentElement), colour = (name) => style.getPropertyValue(name);
    const axis = { stroke: () => colour("--soft"), grid: { stroke: () => colour("--line"), width: 1 }, ticks: { show: false }, font: "10px system-ui" };
    return new uPlot({
      title: strip.title, width: 258, height: 118, cursor: { show: false }, legend: { show: false },
      scales: { x: { time: false }, y: { range: (_, low, high) => rangeOf(low, high) } },
      axes: [{ ...axis, size: 22 }, { ...axis, size: (_, texts) => axisWidth(texts), values: (_, ticks) => ticks.map(short) }],
      series: [{}, ...strip.series.map(([stroke, , dash]) => ({ stroke, dash, width: 1.2, points: { show: false } }))],
      hooks: { draw: [(plot) => this.drawMarker(plot)] },
    }, [[], ...strip.series.map(() => [])], this.parent);
  }
  drawMarker(plot) {
    if (this.marker === null) return;
    const x = plot.valToPos(this.marker, "x", true), { ctx, bbox } = plot;
    ctx.strokeStyle = "#d5452c";
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
  }
}
