// ./run bench page: what the page is worth and what it costs, with 20 robots that stream a keyframe and a cloud a second each.

import { existsSync, mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync, chmodSync } from 'node:fs';
import { get } from 'node:http';
import { dirname, join } from 'node:path';
import { browserArguments, browserPath, chromium, finished, needs, outputs, scratchFolder, start, Station, until } from '../tests/support.mjs';
import { large, largeMap } from './large_map.mjs';
import { firstPicture, openPage, pause, quantile, residentMb } from './measure.mjs';

const robots = 20;
const seconds = 30;
const long_s = 1800; // a load that is ended by hand
const rounds = 4; // with and without a page, in turn: the machine is not the same from minute to minute
const firstPictures = 20;
const pages = 10;
const poll_ms = 20;
const bars = { first_picture_p95_ms: 1000, live_lag_p95_ms: 500, ingest_cost_share: 0.1, bundle_kb: 400, memory_ten_pages_mb: 50 };

needs('headframe-server', 'headframe-link-bench', 'headframe-replay', 'headframe-drawn-sessions');
const scratch = scratchFolder();
const results = join(outputs, 'page.json');

/** The server that a load started. */
class LoadedServer {
  constructor(pid, url, token, folder) {
    Object.assign(this, { pid, url, token, folder });
  }
  async sessions() {
    const headers = this.token ? { Authorization: `Bearer ${this.token}` } : {};
    return (await (await fetch(`${this.url}api/v1/sessions`, { headers })).json()).sessions;
  }
  async end() {
    const answers = () => fetch(`${this.url}healthz`).then(() => true, () => false);
    if (await answers()) process.kill(this.pid, 'SIGKILL');
    await until('the end of a server', async () => !(await answers()));
  }
}

/** Found among the processes: its port and token are in files beside its data. */
function serverOf(load) {
  for (const pid of readdirSync('/proc').filter((name) => /^\d+$/.test(name))) {
    let args;
    try {
      const parent = / (\d+)/.exec(readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1])[1];
      if (Number(parent) !== load.pid) continue;
      args = readFileSync(`/proc/${pid}/cmdline`, 'utf8').split('\0');
    } catch {
      continue; // it ended meanwhile
    }
    const data = args[args.indexOf('--data') + 1];
    if (!args[0].endsWith('headframe-server') || !data) continue;
    let log = '';
    try {
      log = readFileSync(join(dirname(data), 'server.log'), 'utf8');
    } catch {
      return null;
    }
    const match = /ready: .*http on ([^\s,]+)/.exec(log);
    if (!match) return null;
    const folder = dirname(data);
    const token = args.includes('--insecure') ? '' : readFileSync(join(data, 'operator.token'), 'utf8').trim();
    return new LoadedServer(Number(pid), `http://${match[1]}/`, token, folder);
  }
  return null;
}

/** Robots on a server of their own, for as long as the load takes, and its figures; without load_s until `meanwhile` is done. */
async function underLoad(load_s, meanwhile, points = []) {
  const folder = join(scratch, `load-${Math.random().toString(36).slice(2)}`);
  mkdirSync(folder);
  const load = start('headframe-link-bench', ['load', '--robots', String(robots), '--seconds', String(load_s ?? long_s), ...points], { cwd: folder });
  const server = await until('a server under load', () => serverOf(load));
  await until('all robots', async () => (await server.sessions()).filter(({ keyframes }) => keyframes > 3).length === robots);
  await meanwhile(server, load);
  if (load_s === null) {
    load.kill();
    await server.end();
    rmSync(server.folder, { recursive: true, force: true }); // the load would have
    return null;
  }
  await finished(load);
  return JSON.parse(readFileSync(join(folder, 'build/bench/link.json'), 'utf8')).link;
}

const launch = (executablePath = browserPath) => chromium.launch({ executablePath, args: browserArguments });

/** The browser is another computer: here it gets what the server and the robots leave, and nothing else (as root it would give itself priority). */
function launchAside() {
  const wrapper = join(scratch, 'aside');
  const humbly = process.getuid() === 0 ? 'setpriv --bounding-set=-sys_nice ' : '';
  writeFileSync(wrapper, `#!/bin/sh\nexec ${humbly}chrt --idle 0 ${browserPath} "$@"\n`);
  chmodSync(wrapper, 0o755);
  return launch(wrapper);
}

/** From the last look at which the server did not have a keyframe to the frame after the one that shows it. */
async function liveLag(page, server, lag_s) {
  await page.evaluate(() => {
    window.seen = [];
    const last = new Map();
    const look = () => {
      for (const [id, count] of window.headframe.shown.keyframes)
        if (last.get(id) !== count) {
          for (let number = (last.get(id) ?? count - 1) + 1; number <= count; number++) window.seen.push([id, number, Date.now()]);
          last.set(id, count);
        }
      requestAnimationFrame(look);
    };
    look();
  });
  const came = new Map();
  const counts = new Map();
  let before = Date.now();
  for (const end = Date.now() + 1000 * lag_s; Date.now() < end; ) {
    const asked = Date.now();
    for (const { id, keyframes } of await server.sessions()) {
      if (counts.has(id)) for (let number = counts.get(id) + 1; number <= keyframes; number++) came.set(`${id} ${number}`, before);
      counts.set(id, keyframes);
    }
    before = asked;
    await pause(Math.max(0, asked + poll_ms - Date.now()));
  }
  const seen = await page.evaluate(() => window.seen);
  return seen.filter(([id, number]) => came.has(`${id} ${number}`)).map(([id, number, at]) => Math.max(0, at - came.get(`${id} ${number}`)));
}

function transferred(url) {
  return new Promise((resolve, reject) =>
    get(url, (response) => {
      let bytes = 0;
      response.on('data', (data) => (bytes += data.length));
      response.on('end', () => resolve(bytes));
    }).on('error', reject),
  );
}

/** Robots that have all been there: what a server grows by is then the pages' alone. */
async function memoryOfPages(opener) {
  const drives = join(scratch, 'drives');
  await finished(start('headframe-drawn-sessions', [drives]));
  const station = await Station.start(join(scratch, 'still'));
  const folders = ['a', 'b', 'c'];
  for (let at = 0; at < robots; at++) await finished(station.replay(`r${at}`, join(drives, folders[at % folders.length])));
  await station.json('api/v1/atlas?wait=300');
  const before = residentMb(station.process.pid);
  const server = { url: station.url, token: '' };
  const opened = [];
  for (let at = 0; at < pages; at++) {
    opened.push(await openPage(opener, server));
    await firstPicture(opened[at]);
  }
  await pause(5000); // finer levels of detail come meanwhile
  const grown = residentMb(station.process.pid) - before;
  await Promise.all(opened.map((page) => page.context().close()));
  await station.kill();
  return grown;
}

const say = (text) => process.stderr.write(`page bench: ${text}\n`);

/** After each part, so that one that fails does not take the others along. */
function save() {
  mkdirSync(outputs, { recursive: true });
  writeFileSync(results, `${JSON.stringify({ page: figures }, null, 1)}\n`);
}

const middle = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

async function ingest() {
  Object.assign(figures, { robots, without_page_p99_ms: [], with_page_p99_ms: [] });
  for (let round = 0; round < rounds; round++) {
    say(`round ${round + 1} of ${rounds}: ${robots} robots without a page, then with one`);
    figures.without_page_p99_ms.push((await underLoad(seconds, () => {})).ack_p99_ms);
    const aside = await launchAside();
    const load = await underLoad(seconds, async (server) => void (await firstPicture(await openPage(aside, server))));
    figures.with_page_p99_ms.push(load.ack_p99_ms);
    await aside.close();
  }
  figures.ingest_cost_share = middle(figures.with_page_p99_ms) / middle(figures.without_page_p99_ms) - 1;
}

async function pictures(browser) {
  say('live update lag, then first pictures');
  await underLoad(null, async (server) => {
    const files = ['', 'page.js', 'page.css', 'page.woff2'];
    figures.bundle_kb = (await Promise.all(files.map((name) => transferred(server.url + name)))).reduce((sum, bytes) => sum + bytes, 0) / 1000;
    const page = await openPage(browser, server);
    await firstPicture(page); // and the graphics process of the browser has been started
    const lag = await liveLag(page, server, seconds / 2);
    Object.assign(figures, { live_lag_keyframes: lag.length, live_lag_p50_ms: quantile(lag, 0.5), live_lag_p95_ms: quantile(lag, 0.95) });
    await page.context().close();
    const times = [];
    for (let at = 0; at < firstPictures; at++) {
      const opened = await openPage(browser, server);
      times.push(await firstPicture(opened));
      await opened.context().close();
    }
    Object.assign(figures, { first_picture_p50_ms: quantile(times, 0.5), first_picture_p95_ms: quantile(times, 0.95) });
  });
}

async function memory(browser) {
  say(`memory of the server with ${pages} pages`);
  figures.memory_ten_pages_mb = await memoryOfPages(browser);
}

async function largeOne(browser) {
  say('a map of more than 10 million points');
  await underLoad(
    null,
    async (server, load) => {
      await until('a large map', async () => (await server.sessions()).every(({ clouds }) => clouds >= large.clouds));
      load.kill();
      await server.end();
      // It opens what is there, and leaves it: noise would keep it busy with comparisons.
      const config = join(server.folder, 'still.toml');
      writeFileSync(config, '[merge]\nleast_path_m = 1000\n');
      const station = await Station.start(join(server.folder, 'data'), { more: ['--config', config] });
      figures.large = await largeMap(browser, station);
      await station.kill();
    },
    ['--points', String(large.points_a_cloud)],
  );
}

const inBrowser = (work) => async () => {
  const browser = await launch();
  await work(browser);
  await browser.close();
};
const parts = { ingest, pictures: inBrowser(pictures), memory: inBrowser(memory), large: inBrowser(largeOne) };
const wanted = process.argv.slice(2);
const unknown = wanted.filter((name) => !(name in parts));
if (unknown.length) {
  say(`there is no part ${unknown.join(', ')}; there are ${Object.keys(parts).join(', ')}`);
  process.exit(2);
}
const figures = existsSync(results) ? JSON.parse(readFileSync(results, 'utf8')).page : {};
for (const [name, part] of Object.entries(parts)) {
  if (wanted.length && !wanted.includes(name)) continue;
  await part();
  save();
}

console.log(`page (${robots} robots, a keyframe and a cloud a second each; software rendering on the same machine)`);
for (const [name, bar] of Object.entries(bars)) console.log(`  ${name.padEnd(24)} ${figures[name]?.toFixed(2).padStart(9) ?? 'not measured'}  bar ${bar}`);
if (figures.large) {
  const { map_points, software, ...kept } = figures.large;
  console.log(`  a map of ${map_points} points; at most ${large.kept} are kept and ${large.drawn} drawn in a frame, by software 100000`);
  for (const [words, part] of [['as with a graphics card', kept], ['as without', software]])
    console.log(
      `    ${words}: first picture ${part.first_picture_ms.toFixed(0)} ms, ${part.points_kept} kept, at most ${part.most_drawn} drawn; dragged ${part.drawn_while_dragged} in ${part.frame_p50_ms.toFixed(0)} ms (p95 ${part.frame_p95_ms.toFixed(0)} ms)`,
    );
}
process.exit(0);
