// npm packages in another folder than this one: that of npm ci.
import { createRequire } from 'node:module';
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

/** Returns the module of a package in FOLDER/node_modules. Throws if it is not installed. */
export async function importFrom(folder, name) {
  const file = createRequire(resolve(folder, 'package.json')).resolve(name);
  return import(pathToFileURL(file).href);
}
