// A module of the page, as the page has it.

import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

export async function load(name) {
  const file = fileURLToPath(new URL(`../src/${name}.ts`, import.meta.url));
  const { outputFiles } = await build({ entryPoints: [file], bundle: true, write: false, format: 'esm', platform: 'node' });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString('base64')}`);
}
