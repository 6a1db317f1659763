// The real programs and a real browser, for tests and the bench.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { accessSync, constants, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

/** Ends the script with one line. */
function stop(line) {
  process.stderr.write(`headframe: ${line}\n`);
  process.exit(2);
}

const bin = process.env.HEADFRAME_BIN;
export const outputs = process.env.HEADFRAME_OUT;
if (!bin || !outputs) stop('HEADFRAME_BIN and HEADFRAME_OUT say where the programs are and where pictures and figures go; ctest and ./run bench page set them');

export const { chromium } = await import('playwright-core').catch(() => stop("playwright-core is not there; the server's build fetches it: cmake --build --preset release --target headframe-server"));
export const browserPath = process.env.CHROMIUM ?? '/usr/bin/chromium';

/** Says at once what the script will lack. */
export function needs(...programs) {
  const runs = (file) => {
    try {
      accessSync(file, constants.X_OK);
      return true;
    } catch {
      return false;
    }
  };
  const missing = programs.filter((name) => !runs(join(bin, name)));
  if (missing.length) stop(`not in ${bin}: ${missing.join(', ')}; build them first: cmake --build --preset release --target ${missing.join(' ')}`);
  if (!runs(browserPath)) stop(`there is no browser at ${browserPath}; install chromium, or say in CHROMIUM where one is`);
}

const between_ms = 50; // of two looks: what is waited for needs the processor itself
export const patience_ms = Number(process.env.PATIENCE_MS ?? 150_000); // for machines that are busy; nothing waits longer than it has to

/** A folder that goes with the process. */
export function scratchFolder() {
  const folder = mkdtempSync(join(tmpdir(), 'headframe-page-'));
  process.on('exit', () => rmSync(folder, { recursive: true, force: true }));
  return folder;
}

const children = new Set();

export function start(program, args, options = {}) {
  const child = spawn(join(bin, program), args, { stdio: ['ignore', 'pipe', 'pipe'], ...options });
  child.text = '';
  for (const stream of [child.stdout, child.stderr]) stream.on('data', (data) => (child.text += data));
  children.add(child);
  child.on('exit', () => children.delete(child));
  return child;
}

/** Ends every program that still runs: one that a failed test left behind would keep the script from ending. */
export function endAll() {
  for (const child of children) child.kill('SIGKILL');
}
process.on('exit', endAll);

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

/** A browser and a server, beside drawn drives to play. */
export async function browserAndStation(scratch, options) {
  await finished(start('headframe-drawn-sessions', [join(scratch, 'drives')]));
  return [await launch(), await Station.start(join(scratch, 'data'), options)];
}

export const browserArguments = ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];

export const launch = () => chromium.launch({ executablePath: browserPath, args: browserArguments });

/** As the page does: all pages of the context are let in from then on. */
export async function signIn(context, url, token) {
  const answer = await context.request.post(new URL('/api/v1/sign-in', url).href, { headers: { Authorization: `Bearer ${token}` } });
  if (!answer.ok()) throw new Error(`sign-in: ${answer.status()}`);
}

/** A page whose faults are kept: whatever the console calls an error, but what matches `allowed`. `before` runs before it is
 * fetched. */
export async function open(browser, url, { allowed, before, token, ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, reducedMotion: 'reduce', ...options });
  if (token) await signIn(context, url, token);
  const page = await context.newPage();
  page.setDefaultTimeout(patience_ms);
  page.faults = [];
  page.allowed = allowed;
  const fault = (text) => page.allowed?.test(text) || page.faults.push(text);
  page.on('console', (message) => ['error', 'warning'].includes(message.type()) && fault(message.text()));
  page.on('pageerror', (error) => fault(error.stack));
  await before?.(page);
  await page.goto(url);
  return page;
}

/** What the view shows, by the page's own count; nothing before the page's script has run. */
export const shown = (page) =>
  page.evaluate(() => {
    const { shown = { points: 0, keyframes: new Map(), until: new Map() } } = window.headframe ?? {};
    return { ...shown, keyframes: [...shown.keyframes.values()], until: [...shown.until.values()] };
  });

export const picture = (page, name) => page.screenshot({ path: join(outputs, `${name}.png`) });

const require = createRequire(import.meta.url);

export const widths = [1280, 820, 390];

/** Of a part of the page, at three widths from a desk to a phone; nothing hangs over. */
export async function auditWidths(page, name, part) {
  const before = page.viewportSize();
  for (const width of widths) {
    await page.setViewportSize({ width, height: 800 });
    await audit(page, part);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width, 'nothing hangs over');
    await picture(page, `${name}_${width}`);
  }
  await page.setViewportSize(before);
}

/** Nothing that a screen reader or weak eyes would stumble over badly, in dark and in light; of a part, or of all. */
export async function audit(page, part = 'html') {
  await page.evaluate(`${readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8')}; 0`); // no script tag: the page's policy refuses it
  for (const colorScheme of ['dark', 'light']) {
    await page.emulateMedia({ colorScheme });
    await until(`a page that is ${colorScheme}`, () => page.evaluate((wanted) => document.documentElement.dataset.theme === wanted, colorScheme));
    const { violations, passes } = await page.evaluate((looked) => window.axe.run({ include: [looked] }, { resultTypes: ['violations'] }), part);
    assert.ok(passes.length > (part === 'html' ? 10 : 4), 'the audit looked');
    const grave = violations.filter(({ impact }) => impact === 'serious' || impact === 'critical');
    assert.deepEqual(grave.flatMap(({ id, nodes }) => nodes.map(({ target, failureSummary }) => `${colorScheme}: ${id}: ${target} ${failureSummary}`)), []);
  }
  await page.emulateMedia({ colorScheme: null });
}
