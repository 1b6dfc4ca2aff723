// The selected body, joint or drive: its name, pose, force, and curves of its own.
import * as THREE from "three";
import { Strips } from "./strips.js";
import { bodyPose, couplingForce, feedbackForce } from "./wire.js";

const CLICK_PIXELS = 4, HISTORY_S = 20, HISTORY_BYTES = 32 << 20;
const TITLES = { body: "bodies", joint: "joints", device: "drives and joints of the device", term: "springs, gears, closing joints" };
const AXES = ["#d5452c", "#2c9c5a", "#3b7dd8"];
const degrees = (x) => THREE.MathUtils.radToDeg(x);

// Lists all that can be selected, as { kind, index, name }.
export function thingsOf(about) {
  const list = (kind, names) => names.map((name, index) => ({ kind, index, name }));
  return [...list("body", about.bodies.map((body) => body.name)), ...list("joint", about.joints.map((joint) => joint.name)),
    ...list("device", about.device_joints ?? []), ...list("term", about.terms ?? [])];
}

// Returns the sum of the contact forces on a body, N.
export function contactForce(frame, body) {
  const sum = [0, 0, 0];
  for (let i = 0; i < frame.numContacts; ++i)
    for (const [side, sign] of [[0, 1], [1, -1]])
      if (frame.contactWords[11 * i + side] === body) for (let k = 0; k < 3; ++k) sum[k] += sign * frame.contacts[11 * i + 8 + k];
  return sum;
}

// Returns the strips of a thing: title, and series of colour and value(frame).
export function stripsOf(about, { kind, index }) {
  const own = (about.values ?? []).flatMap((value, i) => value.of === kind && value.index === index ? [{ ...value, i }] : []);
  if (kind !== "body") {
    return own.map(({ name, unit, i }) => {
      const scale = unit === "rad" ? degrees(1) : unit === "m" ? 1e3 : 1;
      return { title: `${name}, ${{ rad: "°", m: "mm" }[unit] ?? unit}`, series: [[AXES[2], (frame) => frame.values.length ? scale * frame.values[i] : null]] };
    });
  }
  const target = about.driven.indexOf(index), strips = [
    { title: "position, mm (x red, y green, z blue)", series: AXES.map((colour, k) => [colour, (frame) => 1e3 * bodyPose(frame, index)[k]]) },
    { title: "contact force, N", series: [[AXES[2], (frame) => Math.hypot(...contactForce(frame, index))]] }];
  if (target >= 0) {
    strips.push({ title: "coupling, N", series: [[AXES[1], (frame) => Math.hypot(...couplingForce(frame, target))]] },
      { title: "force to the hand, N", series: [[AXES[0], (frame) => Math.hypot(...feedbackForce(frame, target))]] });
  }
  return strips;
}

const written = (values, digits, unit) => `${[...values].map((x) => x.toFixed(digits)).join(", ")} ${unit}`;

// Returns position, mm, and turn about x, y, z, degrees, as texts.
function poseLines(p, q) {
  const turn = new THREE.Euler().setFromQuaternion(q, "ZYX");
  return [["position", written(p.map((x) => 1e3 * x), 1, "mm")], ["turn x, y, z", written([turn.x, turn.y, turn.z].map(degrees), 1, "°")]];
}

export class Inspector {
  // select: receives the index of the selected body, or null
  constructor(view, canvas, panel) {
    Object.assign(this, { view, canvas, panel, history: [], bytes: 0, thing: null, strips: null, about: null });
    const by = (name) => panel.querySelector(`[data-part=${name}]`);
    Object.assign(this, { list: by("list"), facts: by("facts"), curves: by("curves") });
    this.list.onchange = () => this.select(this.things[this.list.value] ?? null);
    canvas.addEventListener("pointerdown", (event) => { this.pressed = event.button === 0 ? { x: event.clientX, y: event.clientY } : null; }, { capture: true });
    canvas.addEventListener("pointerup", (event) => {
      if (this.pressed && Math.hypot(event.clientX - this.pressed.x, event.clientY - this.pressed.y) < CLICK_PIXELS) this.select(this.under(event));
    });
  }

  setScene(about) {
    Object.assign(this, { about, history: [], bytes: 0, things: thingsOf(about) });
    this.list.replaceChildren(new Option("click a body or joint, or choose", ""));
    for (const kind of Object.keys(TITLES)) {
      const group = Object.assign(document.createElement("optgroup"), { label: TITLES[kind] });
      this.things.forEach((thing, i) => { if (thing.kind === kind) group.append(new Option(thing.name, String(i))); });
      if (group.childElementCount) this.list.append(group);
    }
    this.select(null);
  }

  // Returns the thing at a place of the canvas, or null. Shown joints are before bodies.
  under(event) {
    const box = this.canvas.getBoundingClientRect(), ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2((event.clientX - box.left) / box.width * 2 - 1, 1 - (event.clientY - box.top) / box.height * 2), this.view.camera);
    const joints = this.view.show.joints ? this.view.joints ?? [] : [];
    const at = ray.intersectObjects(joints.map((joint) => joint.children[0]), false)[0];
    if (at) return this.named("joint", joints.indexOf(at.object.parent));
    const hit = ray.intersectObjects(this.view.bodies ?? [], true).find((one) => one.object.isMesh && one.object.visible);
    let object = hit?.object;
    while (object && object.userData.body === undefined) object = object.parent;
    return object ? this.named("body", object.userData.body) : null;
  }
  named(kind, index) { return this.things.find((thing) => thing.kind === kind && thing.index === index) ?? null; }

  select(thing) {
    this.thing = thing;
    this.strips?.remove();
    this.strips = thing && new Strips(this.curves, stripsOf(this.about, thing));
    this.list.value = thing ? String(this.things.indexOf(thing)) : "";
    this.facts.replaceChildren();
    this.view.select(thing?.kind === "body" ? thing.index : null);
    for (const frame of this.history) this.strips?.add(frame, this.about.driven);
  }

  // Keeps frames for curves from before the click; all of a recording.
  add(frame, whole = false) {
    const isOfAnotherRun = this.history.length && frame.t < this.history.at(-1).t;
    if (isOfAnotherRun) Object.assign(this, { history: [], bytes: 0 });
    if (frame.t === this.history.at(-1)?.t) return;  // of a paused run
    this.history.push(frame);
    this.bytes += frame.bytes;
    while (!whole && (frame.t - this.history[0].t > HISTORY_S || this.bytes > HISTORY_BYTES)) this.bytes -= this.history.shift().bytes;
    this.strips?.add(frame, this.about.driven);
  }

  // Writes the numbers of this frame.
  write(frame) {
    if (!this.thing) return;
    const lines = this.lines(frame), text = lines.map(([name, value]) => `${name}\t${value}`).join("\n");
    if (this.facts.dataset.text === text && this.facts.childElementCount) return;
    this.facts.dataset.text = text;
    this.facts.replaceChildren(...lines.flatMap(([name, value]) =>
      [Object.assign(document.createElement("dt"), { textContent: name }), Object.assign(document.createElement("dd"), { textContent: value })]));
  }
  lines(frame) {
    const { kind, index } = this.thing, { about } = this;
    const own = stripsOf(about, this.thing).filter(({ series }) => series.length === 1).map(({ title, series }) => {
      const [name, unit] = title.split(", "), value = series[0][1](frame);
      return [name, Number.isFinite(value) ? `${Number(value.toPrecision(4))} ${unit}` : "not known"];
    });
    if (kind === "body") {
      const X = bodyPose(frame, index);
      return [["mass", `${Number((1e3 * about.bodies[index].mass).toPrecision(4))} g`], ...poseLines([...X.subarray(0, 3)], new THREE.Quaternion(...X.subarray(3))), ...own];
    }
    if (kind !== "joint") return own;
    const joint = about.joints[index], drawn = this.view.joints[index], at = new THREE.Vector3(), q = new THREE.Quaternion(), name = (i) => i === null ? "the world" : about.bodies[i].name;
    drawn.updateWorldMatrix(true, false);
    drawn.matrixWorld.decompose(at, q, new THREE.Vector3());
    return [["kind", joint.kind], ["connects", `${name(joint.parent)} and ${name(joint.child)}`], ...poseLines(at.toArray(), q), ...own];
  }
}
