// Runs MuJoCo, Jolt and Rapier on the scenes that the study has written, and writes their rows as JSON.
// usage: node run.mjs --packages FOLDER --plan PLAN.json --out ROWS.json
import { readFileSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { parseArgs } from 'node:util';
import { bagOf } from './bag.mjs';
import { contactOf } from './contact.mjs';
import { errorsOf } from './error.mjs';
import * as jolt from './jolt.mjs';
import * as mujoco from './mujoco.mjs';
import { stretchOf } from './net.mjs';
import { importFrom } from './packages.mjs';
import { pileOf } from './pile.mjs';
import * as rapier from './rapier.mjs';
import { load } from './scene.mjs';
import { distanceOf, stiffened } from './stability.mjs';

const usage = 'node run.mjs --packages FOLDER --plan PLAN.json --out ROWS.json';

function options() {
  const text = { type: 'string' };
  const { values } = parseArgs({ options: { packages: text, plan: text, out: text } });
  for (const name of ['packages', 'plan', 'out'])
    if (!values[name]) throw new Error(`--${name} is missing: ${usage}`);
  return values;
}

function versionOf(folder, name) {
  return JSON.parse(readFileSync(join(folder, 'node_modules', name, 'package.json'), 'utf8')).version;
}

async function variantsOf(folder) {
  const all = [], versions = [];
  for (const engine of [mujoco, jolt, rapier]) {
    all.push(...await engine.variants(await importFrom(folder, engine.packageName)));
    versions.push(`${engine.packageName} ${versionOf(folder, engine.packageName)}`);
  }
  return { all, versions: versions.join(', ') };
}

async function main() {
  const { packages, plan: planFile, out } = options();
  const plan = JSON.parse(readFileSync(planFile, 'utf8'));
  const sceneOf = (file) => load(join(dirname(planFile), file));
  const { all, versions } = await variantsOf(packages);
  const rows = { versions, errors: [], contacts: [], piles: [], nets: [], bags: [], stability: [] };

  for (const scene of plan.errors.map(sceneOf)) {
    for (const variant of all.filter((v) => v.can(scene)))
      for (const h of plan.steps)
        rows.errors.push({ scene: scene.name, engine: variant.name, h, ...errorsOf(variant, scene, h) });
    if (scene.name !== 'S1') continue;
    const { stiffnesses, steps, duration } = plan.stiffened;
    for (const variant of all.filter((v) => v.can(scene)))
      for (const k of stiffnesses)
        for (const h of steps)
          rows.stability.push(
            { engine: variant.name, k, h, distance: distanceOf(variant, stiffened(scene, k), h, duration) });
  }
  for (const scene of plan.contacts.map(sceneOf))
    for (const variant of all.filter((v) => v.can(scene)))
      rows.contacts.push({ engine: variant.name, k: scene.bodies[0].coupling.k, ...contactOf(variant, scene) });
  for (const scene of plan.piles.map(sceneOf))
    for (const variant of all.filter((v) => v.can(scene)))
      rows.piles.push({ engine: variant.name, ...pileOf(variant, scene) });
  for (const net of plan.nets)
    for (const variant of all.filter((v) => v.makeNet))
      rows.nets.push({ engine: variant.name, ...stretchOf(variant, net) });
  for (const bag of plan.bags)
    for (const variant of all.filter((v) => v.makeBag))
      rows.bags.push({ engine: variant.name, ...bagOf(variant, bag) });
  writeFileSync(out, JSON.stringify(rows, null, 1));
}

await main();
