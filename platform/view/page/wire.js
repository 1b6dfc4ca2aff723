// Binary frames and pointer messages: docs/view.md.

const FRAME = 0x46564f47, POINTER = 0x50564f47, PACE = 0x43564f47, RESET = 0x52564f47, VERSION = 1, JOINTS_VERSION = 2, MAX_JOINTS = 16;
const BODY = 28, DRIVEN = 76, CONTACT = 44, VERTEX = 12;
export const PHASES = ["off", "booting", "running", "running down", "closing", "ended"];
export const ENGAGED = 1, ON_HOLD = 2, OSCILLATES = 4, MISSED_DEADLINES = 8, PAUSED = 16;
export const NONE = 0xffffffff;

// Decodes the frame at this offset of a buffer; `end` is the offset of the next. Poses are views of the
// buffer.
export function decodeFrame(buffer, at = 0) {
  const data = new DataView(buffer, at), u32 = (i) => data.getUint32(i, true), f32 = (i) => data.getFloat32(i, true);
  if (u32(0) !== FRAME || data.getUint16(4, true) !== VERSION) throw new Error("this is no frame of version 1: reload the page");
  const numBodies = u32(44), numDriven = data.getUint16(26, true), numContacts = u32(48), numVertices = u32(52), numValues = u32(120);
  let next = at + data.getUint16(6, true);
  const floats = (count) => { const part = new Float32Array(buffer, next, count); next += 4 * count; return part; };
  const frame = {
    cycle: Number(data.getBigUint64(8, true)), t: data.getFloat64(16, true),
    phase: data.getUint8(24), flags: data.getUint8(25), fault: u32(28), limited: u32(32), rigFault: u32(36),
    held: data.getInt32(40, true), stepUs: f32(56), wakeUs: f32(60), energy: f32(64), balance: f32(68),
    followingM: f32(72), followingRad: f32(76), handForce: [f32(80), f32(84), f32(88)], handTorque: [f32(92), f32(96), f32(100)],
    busFrames: u32(104), incomplete: u32(108), numTouching: u32(112), deepest: f32(116), impactSpeed: f32(124), numImpacts: u32(128),
    numBodies, numDriven, numContacts, numVertices,
  };
  frame.bodies = floats(numBodies * BODY / 4);
  frame.driven = floats(numDriven * DRIVEN / 4);
  frame.contactWords = new Uint32Array(buffer, next, numContacts * CONTACT / 4);
  frame.contacts = floats(numContacts * CONTACT / 4);
  frame.vertices = floats(numVertices * VERTEX / 4);
  frame.values = floats(numValues);
  frame.end = next;
  frame.bytes = next - at;
  return frame;
}

export const bodyPose = (frame, i) => frame.bodies.subarray(7 * i, 7 * i + 7);
export const targetPose = (frame, i) => frame.driven.subarray(19 * i, 19 * i + 7);
export const couplingForce = (frame, i) => frame.driven.subarray(19 * i + 7, 19 * i + 10);
export const feedbackForce = (frame, i) => frame.driven.subarray(19 * i + 13, 19 * i + 16);

export function encodePointer({ number, holds, moves, target, shift, turn }) {
  const data = new DataView(new ArrayBuffer(40));
  data.setUint32(0, POINTER, true);
  data.setUint16(4, VERSION, true);
  data.setUint16(6, (holds ? 1 : 0) | (moves ? 2 : 0), true);
  data.setUint32(8, number, true);
  data.setUint32(12, target, true);
  [...shift, ...turn].forEach((x, i) => data.setFloat32(16 + 4 * i, x, true));
  return data.buffer;
}

// shift: displacement of each coordinate of the scene since the previous message, rad or m.
export function encodeJoints({ number, holds, shift }) {
  const data = new DataView(new ArrayBuffer(16 + 4 * MAX_JOINTS));
  data.setUint32(0, POINTER, true);
  data.setUint16(4, JOINTS_VERSION, true);
  data.setUint16(6, holds ? 1 : 0, true);
  data.setUint32(8, number, true);
  data.setUint32(12, shift.length, true);
  shift.forEach((x, i) => data.setFloat32(16 + 4 * i, x, true));
  return data.buffer;
}

// speed: simulated time per wall time; 0: paused, Infinity: unlimited. steps: periods to run in the pause.
export function encodePace({ speed, steps }) {
  const data = new DataView(new ArrayBuffer(12));
  data.setUint32(0, PACE, true);
  data.setUint16(4, VERSION, true);
  data.setUint16(6, steps, true);
  data.setFloat32(8, speed, true);
  return data.buffer;
}

// Starts the run again.
export function encodeReset() {
  const data = new DataView(new ArrayBuffer(8));
  data.setUint32(0, RESET, true);
  data.setUint16(4, VERSION, true);
  return data.buffer;
}
