// MuJoCo as the slow world of a run: a block on a spring, held by the tool, at 60 Hz over the run's shared memory.
// usage: node mujoco_world.mjs PACKAGES NAME SECONDS; prints `ready`, then as JSON
// the block's place, its largest push and the longest period.
import { closeSync, existsSync, openSync, readSync, writeSync } from 'node:fs';
import { crc32 } from './crc32.mjs';
import { importFrom } from '../bench/wasm/packages.mjs';

const [, , packages, name, seconds] = process.argv;
const rate = 60, substeps = 16, id = 1;
const toolAt = 72, toolSize = 1248, worldSize = 768, worldAt = toolAt + toolSize + 8, planesOfTool = 80 + 8 * 104;

const { default: load } = await importFrom(packages, '@mujoco/mujoco');
const mujoco = await load({ print: () => {}, printErr: () => {} });
const model = mujoco.MjModel.from_xml_string(`<mujoco>
  <option timestep="${1 / rate / substeps}" gravity="0 0 0" integrator="implicitfast"/>
  <worldbody><body pos="0.085 0 0"><joint type="slide" axis="1 0 0" stiffness="400" damping="40"/>
    <geom type="box" size="0.05 0.3 0.3" mass="0.5"/></body></worldbody></mujoco>`);
const data = new mujoco.MjData(model);
for (let i = 0; i < 3000; ++i) mujoco.mj_step(model, data);  // compiled now, otherwise in the first periods
mujoco.mj_resetData(model, data);
for (let i = 0; i < 300; ++i) crc32(Buffer.alloc(worldSize));

const path = '/dev/shm/' + name, now = () => Number(process.hrtime.bigint()) * 1e-9;
const sleep = (s) => new Promise((done) => setTimeout(done, Math.max(0, 1000 * s)));
console.log('ready');
for (const end = now() + 20; !existsSync(path);) {
  if (now() > end) throw new Error('no run has made ' + path);
  await sleep(0.05);
}
const file = openSync(path, 'r+');
const read = (at, size) => { const b = Buffer.alloc(size); readSync(file, b, 0, size, at); return b; };
const writeNumber = (at, n) => { const b = Buffer.alloc(8); b.writeBigUInt64LE(n); writeSync(file, b, 0, 8, at); };

/** Returns the newest whole state of the tool, or null. */
function readTool() {
  for (let i = 0; i < 1000; ++i) {
    const before = read(toolAt - 8, 8).readBigUInt64LE(), tool = read(toolAt, toolSize);
    if (before % 2n === 0n && before === read(toolAt - 8, 8).readBigUInt64LE()) return before ? tool : null;
  }
  return null;
}

let number = 0n, taken = 0, largest = 0, longest = 0;
function writePlane(answers, t, x, v, moved) {
  const b = Buffer.alloc(worldSize + 8);
  b.writeUInt32LE(0x314e4957, 0);
  b.writeUInt32LE(1, 4);
  b.writeBigUInt64LE(++number, 8);
  b.writeBigUInt64LE(answers, 16);
  [t, 0.5].forEach((a, i) => b.writeDoubleLE(a, 24 + 8 * i));
  b.writeUInt32LE(1, 40);
  b.writeUInt32LE(id, 48);
  b.writeUInt32LE(1, 52);  // it has moved by:
  [x, 0, 0, -1, 0, 0, v, 0, 0, moved, 0, 0, 1000, 5].forEach((a, i) => b.writeDoubleLE(a, 56 + 8 * i));
  b.writeUInt32LE(crc32(b.subarray(0, worldSize)), worldSize);
  const sequence = read(worldAt - 8, 8).readBigUInt64LE() | 1n;
  writeNumber(worldAt - 8, sequence);
  writeSync(file, b, 0, b.length, worldAt);
  writeNumber(worldAt - 8, sequence + 1n);
}

for (let due = now(), end = due + Number(seconds), last = 0; due < end; due += 1 / rate) {
  await sleep(due - now());
  const tool = readTool();
  if (!tool) continue;
  const t = tool.readDoubleLE(8), dt = last ? t - last : 1 / rate;
  if (dt <= 0) continue;
  let J = 0;
  for (let i = 0; i < 6; ++i)
    if (tool.readUInt32LE(planesOfTool + 56 * i) === id) J = tool.readDoubleLE(planesOfTool + 56 * i + 32);
  data.qfrc_applied[0] = (J - taken) / dt;
  largest = Math.max(largest, (J - taken) / dt);
  longest = Math.max(longest, dt);
  [taken, last] = [J, t];
  const before = data.qpos[0];
  for (let i = Math.round(dt / (1 / rate / substeps)); i > 0; --i) mujoco.mj_step(model, data);
  writePlane(tool.readBigUInt64LE(0), t, 0.035 + data.qpos[0], data.qvel[0], data.qpos[0] - before);
}
console.log(JSON.stringify({ x: data.qpos[0], push: largest, longest_s: longest, packets: Number(number) }));
closeSync(file);
