// The real programs and a real browser, for tests and the bench.

import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

const bin = process.env.HEADFRAME_BIN;
export const outputs = process.env.HEADFRAME_OUT;
if (!bin || !outputs) throw new Error('HEADFRAME_BIN and HEADFRAME_OUT say where the programs are and where pictures go; ctest sets them');

process.setMaxListeners(0);
const between_ms = 50; // of two looks: what is waited for needs the processor itself
export const patience_ms = 150_000; // for machines that are busy; nothing waits longer than it has to

/** A folder that goes with the process. */
export function scratchFolder() {
  const folder = mkdtempSync(join(tmpdir(), 'headframe-page-'));
  process.on('exit', () => rmSync(folder, { recursive: true, force: true }));
  return folder;
}

export function start(program, args, options = {}) {
  const child = spawn(join(bin, program), args, { stdio: ['ignore', 'pipe', 'pipe'], ...options });
  child.text = '';
  for (const stream of [child.stdout, child.stderr]) stream.on('data', (data) => (child.text += data));
  process.on('exit', () => child.kill('SIGKILL'));
  return child;
}

/** Its output; throws when it fails. */
export async function finished(child) {
  if (child.exitCode === null && child.signalCode === null) await once(child, 'exit');
  if (child.exitCode !== 0) throw new Error(`${child.spawnargs.join(' ')} ended with ${child.exitCode ?? child.signalCode}: ${child.text}`);
  return child.text;
}

/** Asks until it holds, and gives what it gave. */
export async function until(what, holds, within_ms = patience_ms) {
  for (const end = Date.now() + within_ms; Date.now() < end; ) {
    const found = await holds();
    if (found) return found;
    await new Promise((resolve) => setTimeout(resolve, between_ms));
  }
  throw new Error(`waited in vain: ${what}`);
}

/** A running headframe-server. */
export class Station {
  /** Ports that were taken once are given, so that a server comes back where it was. */
  static async start(data, { insecure = true, robots = '127.0.0.1:0', http = '127.0.0.1:0', more = [] } = {}) {
    const station = new Station();
    station.data = data;
    const args = ['--data', data, '--listen', robots, '--http', http, ...(insecure ? ['--insecure'] : []), ...more];
    station.process = start('headframe-server', args);
    const ready = /ready: robots on (\S+), http on ([^\s,]+)/;
    const match = await until('a server that is ready', () => {
      if (station.process.exitCode !== null) throw new Error(station.process.text);
      return ready.exec(station.process.text);
    });
    [, station.robots, station.http] = match;
    station.insecure = insecure;
    return station;
  }

  get url() {
    return `http://${this.http}/`;
  }
  get token() {
    return this.insecure ? '' : readFileSync(join(this.data, 'operator.token'), 'utf8').trim();
  }

  async kill() {
    this.process.kill('SIGKILL');
    if (this.process.signalCode === null && this.process.exitCode === null) await once(this.process, 'exit');
  }

  async json(path, method = 'GET') {
    const headers = this.insecure ? {} : { Authorization: `Bearer ${this.token}` };
    const response = await fetch(this.url + path, { method, headers });
    const body = await response.json();
    if (!response.ok) throw new Error(`${path}: ${body.error.message}`);
    return body;
  }

  replay(robot, folder, more = ['--fast']) {
    return start('headframe-replay', ['--server', this.robots, '--robot', robot, '--insecure', ...more, folder]);
  }
}

export const browserPath = process.env.CHROMIUM ?? '/usr/bin/chromium';
export const browserArguments = ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];

export const launch = () => chromium.launch({ executablePath: browserPath, args: browserArguments });

/** A page whose faults are kept: whatever the console calls an error, but what matches `allowed`. */
export async function open(browser, url, { allowed, ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, reducedMotion: 'reduce', ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(patience_ms);
  page.faults = [];
  const fault = (text) => allowed?.test(text) || page.faults.push(text);
  page.on('console', (message) => ['error', 'warning'].includes(message.type()) && fault(message.text()));
  page.on('pageerror', (error) => fault(error.stack));
  await page.goto(url);
  return page;
}

/** What the view shows, by the page's own count; nothing before the page's script has run. */
export const shown = (page) =>
  page.evaluate(() => {
    const { shown = { points: 0, keyframes: new Map() } } = window.headframe ?? {};
    return { ...shown, keyframes: [...shown.keyframes.values()] };
  });

export const picture = (page, name) => page.screenshot({ path: join(outputs, `${name}.png`) });
