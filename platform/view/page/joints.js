// Keys and wheel move the coordinates of an articulated instrument, within the server's rate limits.
import { encodeJoints } from "./wire.js";

const KEY_RATE = { turn: 1, slide: 0.1 };  // rad/s, m/s
const NOTCH = { turn: 0.05, slide: 0.004 }, MOST_NOTCHES = 10;  // rad, m per wheel step; pending steps

export class Joints {
  // coordinates, carriers: of the scene's message; carriers[i] carries the handle of driven body i
  constructor({ coordinates, carriers }, send) {
    Object.assign(this, { coordinates, carriers, send, selected: 0, direction: 0, number: 0, holds: false });
    this.pending = coordinates.map(() => 0);
  }

  kind(i) { return this.coordinates[i].turns ? "turn" : "slide"; }
  select(i) { if (i < this.coordinates.length) this.selected = i; }
  // Returns the coordinate that the wheel moves over this driven body; with shift the parent's coordinate.
  of(target, shift) {
    const own = this.carriers[target] ?? null;
    return own !== null && shift ? this.coordinates[own].parent ?? own : own;
  }
  name(target) {
    const own = this.of(target, false), parent = this.of(target, true);
    if (own === null) return "";
    return `wheel: ${this.coordinates[own].name}` + (parent === own ? "" : ` · shift+wheel: ${this.coordinates[parent].name}`);
  }

  wheel(event, target) {
    const i = target === undefined ? null : this.of(target, event.shiftKey);
    if (i === null) return;  // left to the camera
    event.preventDefault();
    event.stopImmediatePropagation();
    const step = NOTCH[this.kind(i)], way = event.deltaY || event.deltaX;  // shift makes the wheel horizontal
    this.selected = i;
    this.pending[i] = Math.max(-MOST_NOTCHES * step, Math.min(MOST_NOTCHES * step, this.pending[i] - Math.sign(way) * step));
  }

  // Sends a message while any coordinate moves, and a last one. The first one grips the joints and moves
  // none.
  tick(dt) {
    if (document.hidden) {
      this.pending.fill(0);
      this.direction = 0;
    }
    if (this.direction) this.pending[this.selected] = this.direction * KEY_RATE[this.kind(this.selected)] * dt;
    const moves = this.pending.some((x) => x !== 0);
    if (!moves && !this.holds) return;
    const shift = this.pending.map((x, i) => {
      const most = 2 * KEY_RATE[this.kind(i)] * dt;
      return this.holds ? Math.max(-most, Math.min(most, x)) : 0;
    });
    this.pending = this.pending.map((x, i) => x - shift[i]);
    this.holds = moves;
    this.number = (this.number + 1) >>> 0;
    this.send(encodeJoints({ number: this.number, holds: moves, shift }));
  }
}
