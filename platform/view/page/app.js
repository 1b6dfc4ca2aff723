// The page: connection, display, keys and buttons. window.godobject is for tests and the console.
import "./app.css";
import { Cues } from "./cues.js";
import { Camera } from "./film.js";
import { Inspector } from "./inspect.js";
import { Joints } from "./joints.js";
import { Player } from "./player.js";
import { Pointer } from "./pointer.js";
import { connect } from "./source.js";
import { RUN_STRIPS, Strips, divergence, shownForce } from "./strips.js";
import { COLOURS, View } from "./view3d.js";
import { ENGAGED, MISSED_DEADLINES, ON_HOLD, OSCILLATES, PHASES, bodyPose, targetPose } from "./wire.js";

const STALE_MS = 500;
const by = (id) => document.getElementById(id);

// Marks each event once, since the page was opened, to measure the time to the first picture.
const marked = new Set();
function mark(name) {
  if (marked.has(name)) return;
  marked.add(name);
  performance.mark(name);
}

// Connects first, because the server's messages arrive while the view is being set up.
const send = connect({
  scene: (about) => setScene(about),
  frame: (frame) => {
    state.arrived = performance.now();
    state.lost = "";
    strips.add(frame, state.about.driven);  // also those that are not drawn
    inspector.add(frame);
    cues.show(frame, state.about.driven);
    player.arrived(frame);
  },
  // after a regular end the server is gone, and that is no loss
  lost: (why) => { if (!state.ended) state.lost = why; },
  ended: () => { state.ended = true; },
  recording: (frames) => {
    player.load(frames);
    if (frames.length > 1) view.lookAtAll(Array.from({ length: 16 }, (_, i) => frames[Math.round(i / 15 * (frames.length - 1))]));
    for (const frame of frames) {
      strips.add(frame, state.about.driven);
      inspector.add(frame, true);
    }
    by("sheet").hidden = frames.length < 2;
  },
});

mark("begun");
const cues = new Cues();
const view = new View(by("canvas")), strips = new Strips(by("strips"), RUN_STRIPS);
mark("set up");
const state = { about: null, frame: null, arrived: 0, lost: "", ended: false, stale: false, isNew: false, busRate: null };
// Made before the pointer, which keeps presses for itself.
const inspector = new Inspector(view, by("canvas"), by("inspector"));
const pointer = new Pointer(view, by("canvas"), (buffer) => send(buffer));
const player = new Player((frame) => show(frame), (t) => { strips.mark(t); inspector.strips?.mark(t); }, (buffer) => send(buffer, true), () => inspector.history);
const camera = new Camera(view, player, () => `${state.about.name}-${state.frame?.t.toFixed(2) ?? 0}s`);

function show(frame) {
  mark("frame");
  state.frame = frame;
  state.isNew = true;
}

function setScene(about) {
  mark("scene");
  const same = JSON.stringify(about) === JSON.stringify(state.about);
  state.lost = "";
  state.ended = false;
  if (same) return;
  Object.assign(state, { about, frame: null, busRate: null });
  view.setScene(about);
  for (const name of Object.keys(view.show)) view.setShown(name, view.show[name]);
  strips.clear();
  inspector.setScene(about);
  player.setScene(about);
  by("sheet").hidden = true;
  pointer.enabled = about.live && about.takes_pointer;
  pointer.joints = pointer.enabled && about.coordinates?.length ? new Joints(about, (buffer) => send(buffer)) : null;
  by("hand").hidden = !pointer.enabled;
  for (const id of ["grab", "release", "clutch"]) by(id).hidden = Boolean(pointer.joints);
  by("how").textContent = pointer.joints
    ? "Wheel over a part: its coordinate; with shift: that of its parent. 1 to 9: choose one; up and down: move it."
    : "Drag the tool; G keeps the grip. Wheel: depth. Shift: turn.";
  by("name").textContent = about.name;
  by("about").textContent = `${about.about} (${about.title})`;
  by("warning").textContent = about.warning;
  by("warning").hidden = !about.warning;
  document.title = `godobject: ${about.name}`;
}

// Returns the texts of the set bits.
const words = (bits, texts) => texts.filter((_, i) => bits >>> i & 1);

function describe() {
  const { about, frame } = state;
  if (state.lost) return [state.lost, "bad"];
  if (state.ended) return frame?.fault || frame?.rigFault ? ["ended with a FAULT: the last picture", "bad"] : ["ended: the last picture", "warn"];
  if (!frame) return ["waiting for the first frame", "warn"];
  if (state.stale) return ["STALE: no data for " + ((performance.now() - state.arrived) / 1000).toFixed(1) + " s", "bad"];
  if (frame.fault || frame.rigFault || frame.flags & (MISSED_DEADLINES | OSCILLATES)) return ["FAULT, " + PHASES[frame.phase], "bad"];
  if (player.isLive && player.paused) return [player.takesPace ? "the run is paused" : "the picture is paused; the run goes on", "warn"];
  if (player.atEnd) return ["end of the recording", "warn"];
  if (frame.flags & ON_HOLD) return ["deadlines missed: the pose is held", "warn"];
  if (frame.phase !== 2) return [PHASES[frame.phase], "warn"];
  return frame.flags & ENGAGED ? ["running, engaged", "good"] : ["running, not engaged", "good"];
}

function writeState(now) {
  const { about, frame } = state;
  state.stale = Boolean(frame) && about.live && !state.ended && now - state.arrived > STALE_MS;
  if (state.stale || state.ended || state.lost) cues.silence();
  document.body.classList.toggle("stale", state.stale || Boolean(state.lost));
  const [text, kind] = describe();
  if (by("phase").textContent !== text) by("phase").textContent = text;
  by("phase").dataset.kind = kind;
  by("banner").hidden = !(state.lost || state.stale);
  by("banner").textContent = text;
  if (!frame) return;
  by("clock").textContent = `t ${frame.t.toFixed(2)} s · force ${shownForce(frame).toFixed(2)} N · apart ${(1e3 * divergence(frame, about.driven)).toFixed(1)} mm`
    + (frame.numTouching ? ` · ${frame.numTouching} contacts` : "") + (frame.held >= 0 ? ` · holds ${about.bodies[frame.held]?.name}` : "");
  const items = [
    ...words(frame.fault, about.faults).map((bit) => ["fault", bit]), ...words(frame.rigFault, about.rig_faults).map((bit) => ["fault", bit]),
    ...words(frame.limited, about.limits).map((bit) => ["", { name: "limit: " + bit.name, text: bit.text }]),
  ];
  const html = items.map(([kind, bit]) => `<li class="${kind}" title=""></li>`).join("");
  if (by("words").childElementCount !== items.length) by("words").innerHTML = html;
  [...by("words").children].forEach((li, i) => {
    const [kind, bit] = items[i], line = kind ? `${bit.name}: ${bit.text}` : bit.name;
    if (li.textContent !== line) Object.assign(li, { textContent: line, title: bit.text, className: kind });
  });
  writeBuses(frame, now);
}

function writeBuses(frame, now) {
  const { buses } = state.about;
  if (!buses.length) return;
  const last = state.busRate;
  if (!last || now - last.now > 1000) state.busRate = { now, frames: frame.busFrames, rate: last ? Math.round(((frame.busFrames - last.frames) >>> 0) * 1000 / (now - last.now)) : 0 };
  by("buses").textContent = buses.map((bus) => `${bus.name} ${bus.percent.toFixed(0)} % at worst`).join(" · ")
    + ` · ${state.busRate.rate} frames/s · ${frame.incomplete} SYNCs incomplete`;
}

// --- options, keys, legend ----------------------------------------------------------------------

const OPTIONS = [["ghost", "device in wireframe", "d"], ["arrows", "force to the hand", "a"], ["contacts", "contacts", "c"],
  ["spheres", "contact spheres", "s"], ["joints", "joints", "j"], ["frames", "frames of the bodies", "o"], ["labels", "names", "n"],
  ["shadows", "shadows", "h"], ["follow", "follow the tool", "f"]];
for (const [name, text, key] of OPTIONS) {
  const label = document.createElement("label"), box = Object.assign(document.createElement("input"), { type: "checkbox", checked: view.show[name], id: `show-${name}` });
  label.append(box, ` ${text} `, Object.assign(document.createElement("small"), { textContent: key }));
  box.onchange = () => view.setShown(name, box.checked);
  by("options").append(label);
}
by("options").append(Object.assign(document.createElement("small"), { textContent: "R: view all · T: dark, light · L: legend · + -: longer, shorter forces · left drag: orbit, right: pan, wheel: zoom" }));
const LEGEND = [["tool", "tool, as simulated"], ["ghost", "device: pose of the hand"], ["unloaded", "coupling, at rest"], ["loaded", "coupling, at its load"],
  ["force", "force to the hand"], ["contact", "contact forces"], ["body", "other bodies"], ["obstacle", "obstacles"]];
by("legend").innerHTML = LEGEND.map(([name, text]) => `<div><i style="background:#${COLOURS[name].toString(16).padStart(6, "0")}"></i>${text}</div>`).join("") + '<div class="scale" id="scale"><i></i> <span></span></div>';

// Writes the force whose arrow is as long as the bar, at the distance of the camera's target.
function writeScale() {
  const legend = view.forceLegend(), [bar, text] = by("scale").children, written = legend ? `${legend.newtons} N` : "";
  by("scale").hidden = !legend;
  if (!legend) return;
  Object.assign(bar.style, { width: `${legend.pixels.toFixed(0)}px`, background: `#${COLOURS.force.toString(16)}` });
  if (text.textContent !== written) text.textContent = written;
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  view.setTheme(theme);
  strips.changed = true;
}
setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");

// Writes the body that a press would drag, or the coordinates that the wheel moves, and the selected
// coordinate.
function writeHand() {
  const { about } = state, { joints, hover } = pointer;
  const body = hover === null ? "" : about.bodies[about.driven[hover]].name;
  const over = body && (joints ? `${body} · ${joints.name(hover)}` : `drags ${body}`);
  const chosen = joints ? `${joints.selected + 1}: ${joints.coordinates[joints.selected].name}` : "";
  const text = [chosen, over].filter(Boolean).join(" · ");
  if (by("hover").textContent !== text) by("hover").textContent = text;
}

by("screenshot").onclick = () => camera.screenshot();
by("film").onclick = () => camera.toggleFilm();
by("sheet").onclick = () => camera.sheet();
by("sound").onclick = () => cues.toggle();
by("grab").onclick = () => pointer.grab();
by("release").onclick = () => pointer.release();
by("clutch").onclick = () => { pointer.clutch = !pointer.clutch; };
function scaleForces(factor) {
  view.forceFactor = Math.min(64, Math.max(1 / 64, view.forceFactor * factor));
  state.isNew = Boolean(state.frame);
}
const KEYS = {
  r: () => view.lookAtAll(), t: () => setTheme(view.theme === "dark" ? "light" : "dark"), l: () => { by("legend").hidden = !by("legend").hidden; },
  g: () => pointer.grab(), Escape: () => pointer.release(), x: () => { pointer.clutch = true; },
  ArrowUp: () => { if (pointer.joints) pointer.joints.direction = 1; }, ArrowDown: () => { if (pointer.joints) pointer.joints.direction = -1; },
  ...Object.fromEntries([..."123456789"].map((digit) => [digit, () => pointer.joints?.select(digit - 1)])),
  i: () => camera.screenshot(), u: () => cues.toggle(), v: () => camera.toggleFilm(), Home: () => player.reset(),
  "+": () => scaleForces(2), "-": () => scaleForces(0.5),
  " ": () => player.toggle(), ArrowLeft: () => player.step(-1), ArrowRight: () => player.step(1),
};
addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT)$/.test(event.target.tagName) && event.key !== "Escape") return;
  const option = OPTIONS.find(([, , key]) => key === event.key);
  if (option) by(`show-${option[0]}`).click();
  else if (!KEYS[event.key]) return;
  else KEYS[event.key]();
  event.preventDefault();
});
const stopKeys = () => { if (pointer.joints) pointer.joints.direction = 0; };
addEventListener("keyup", (event) => {
  if (event.key === "x") pointer.clutch = false;
  if (/^Arrow(Up|Down)$/.test(event.key)) stopKeys();
});
addEventListener("blur", stopKeys);

// --- running ------------------------------------------------------------------------------------

function draw(now) {
  requestAnimationFrame(draw);
  if (marked.has("drawn")) mark("picture");  // the previous call drew the picture
  player.tick(now);
  if (state.isNew) {
    state.isNew = false;
    view.update(state.frame);
  }
  if (state.frame) {
    view.render();
    mark("drawn");
  }
  writeState(now);
  if (state.frame) {
    inspector.write(state.frame);
    writeScale();
  }
  by("sound").setAttribute("aria-pressed", String(cues.on));
  by("film").setAttribute("aria-pressed", String(Boolean(camera.recorder)));
  by("grab").setAttribute("aria-pressed", String(pointer.holds));
  if (pointer.enabled) writeHand();
  by("clutch").setAttribute("aria-pressed", String(pointer.clutch));
  if (marked.has("picture")) {  // after the first picture
    strips.draw(now, !state.about.live);
    inspector.strips?.draw(now, !state.about.live);
  }
  window.godobject.drawn++;
}

window.godobject = {
  state, view, pointer, player, inspector, camera, cues, writeState, drawn: 0,
  names: () => state.about.bodies.map((body) => body.name),
  body: (name) => [...bodyPose(state.frame, window.godobject.names().indexOf(name))],
  target: (name) => [...targetPose(state.frame, state.about.driven.indexOf(window.godobject.names().indexOf(name)))],
  drawnAt: (name) => view.bodies[window.godobject.names().indexOf(name)].position.toArray(),
  ghostAt: (name) => view.ghosts[state.about.driven.indexOf(window.godobject.names().indexOf(name))].group.position.toArray(),
  pixel: (point) => view.project(point),
  phase: () => by("phase").textContent,
};

requestAnimationFrame(draw);