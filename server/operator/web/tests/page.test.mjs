// The operator's page, in a real browser against the real server, with robots that replay drawn drives.

import assert from 'node:assert/strict';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { audit, endAll, finished, launch, needs, open, outputs, picture, scratchFolder, shown, start, Station, until } from './support.mjs';

needs('headframe-server', 'headframe-replay', 'headframe-drawn-sessions');
const scratch = scratchFolder();
const drives = join(scratch, 'drives');
const mostPoints = 100_000;
let browser;
let station; // robots a and b, which are merged after the first test
let page;

before(async () => {
  mkdirSync(outputs, { recursive: true });
  await finished(start('headframe-drawn-sessions', [drives]));
  browser = await launch();
  station = await Station.start(join(scratch, 'data'));
});

after(async () => {
  await browser?.close();
  endAll();
});

const clean = (opened) => assert.deepEqual(opened.faults, []);
const alignment = async () => (await station.json('api/v1/alignments')).alignments[0];
const stateIs = (state) => until(`an alignment that is ${state}`, async () => (await alignment())?.state === state);
const press = (name) => page.getByRole('button', { name, exact: true }).click();
const closed = () => until('no dialog', async () => (await page.getByRole('dialog').count()) === 0);
// Places on the canvas that fill its middle evenly, one after another (the sequence of Halton in bases 2 and 3).
const halton = (index, base) => (index === 0 ? 0 : (index % base) / base + halton(Math.floor(index / base), base) / base);
let looked = 0;
const elsewhere = ({ width, height }) => (++looked, { x: width * (0.1 + 0.8 * halton(looked, 2)), y: height * (0.2 + 0.6 * halton(looked, 3)) });
const agree = (name) => page.getByRole('dialog').getByRole('button', { name, exact: true }).click();

test('without robots the page says what to do next', async () => {
  page = await open(browser, station.url);
  await page.getByText('No robot has been here yet.').waitFor();
  await page.getByText('The mine is dark.').waitFor();
  await page.getByText('Merges need two sessions.').waitFor();
  await picture(page, 'empty');
  await audit(page);
  clean(page);
});

test('keyframes and points appear while a robot drives, and a merge brings two maps together', async () => {
  const a = station.replay('a', join(drives, 'a'), ['--rate', '5']);
  await until('keyframes on the screen before the robot has finished', async () => (await shown(page)).keyframes.some((count) => count > 3));
  assert.equal(a.exitCode, null, 'the robot still drives');
  const early = (await shown(page)).keyframes[0];
  await until('more of them', async () => (await shown(page)).keyframes[0] > early);
  await until('points', async () => (await shown(page)).points > 0);
  await page.locator('.robot', { hasText: 'a' }).getByText(/^alive [0-9.]+ s ago/).waitFor();
  await picture(page, 'driving');
  // A robot that came after the page was opened, without a revision since.
  await press('Export');
  await page.locator('select[name=component] option', { hasText: 'a' }).waitFor({ state: 'attached' });
  await agree('Cancel');
  const b = station.replay('b', join(drives, 'b'));
  await finished(b);
  await stateIs('published');
  await page.getByRole('button', { name: /a and b: merged; show the evidence/ }).waitFor();
  await finished(a);
  await page.getByText('2 of 2', { exact: false }).first().waitFor();
  const sessions = (await station.json('api/v1/sessions')).sessions;
  await until('every keyframe of the server on the screen', async () => {
    const there = (await shown(page)).keyframes.reduce((sum, count) => sum + count, 0);
    return there === sessions.reduce((sum, { keyframes }) => sum + keyframes, 0);
  });
  assert.ok((await shown(page)).points <= mostPoints, 'no more points than a browser without a graphics card can draw');
  await picture(page, 'merged');
  await audit(page);
  clean(page);
});

test('a merge is taken apart, and that is undone with one click; refused, confirmed and undone', async () => {
  await page.locator('.pair').first().click();
  await page.getByText('are merged', { exact: false }).first().waitFor();
  await page.getByText('What was measured').waitFor();
  await page.locator('.histogram rect').first().waitFor();
  const inks = await page.locator('.picture canvas').evaluate((canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return new Set(Array.from({ length: data.length / 4 }, (_, at) => data.slice(4 * at, 4 * at + 3).join())).size;
  });
  assert.ok(inks > 3, 'the overlay shows one map, the other, and where they meet');
  await picture(page, 'evidence');
  await audit(page);

  await press('Take apart…');
  await picture(page, 'dialog');
  await audit(page);
  await agree('Cancel');
  assert.equal((await alignment()).state, 'published', 'nothing happens before the dialog is agreed to');
  await press('Take apart…');
  await agree('Take apart');
  await page.locator('.toast-offer').click();
  await page.getByText('the decision was undone', { exact: false }).waitFor();
  await stateIs('published');

  await press('Take apart…');
  await agree('Take apart');
  await stateIs('retracted');
  await page.getByText('own frame, not merged').first().waitFor();
  await picture(page, 'apart');
  await press('Undo the decision');
  await stateIs('published');

  await press('Confirm…');
  await agree('Confirm');
  await until('the decision', async () => (await alignment()).decision === 'confirmed');
  await press('Undo the decision');
  await until('no decision', async () => (await alignment()).decision === 'none');
  assert.equal(await page.getByRole('button', { name: 'Refuse…' }).count(), 0, 'what is in force is not refused');

  await press('Take apart…');
  await agree('Take apart');
  await stateIs('retracted');
  await press('Refuse…');
  await agree('Cancel');
  assert.equal((await alignment()).decision, 'retracted', 'nothing happens before the dialog is agreed to');
  await press('Refuse…');
  await agree('Refuse');
  await until('a refusal', async () => (await alignment()).decision === 'refused');
  await page.getByText('refused by the operator', { exact: false }).waitFor();
  assert.equal(await page.getByRole('button', { name: 'Refuse…' }).count(), 0, 'what is refused is not refused again');
  await picture(page, 'refused');
  await page.locator('.toast-offer').last().click();
  await until('the decision before it', async () => (await alignment()).decision === 'retracted');
  await until('no offer to undo it again', async () => (await page.locator('.toast-offer').count()) === 0);
  await press('Undo the decision');
  await stateIs('published');
  await page.getByRole('tab', { name: /Events/ }).click();
  const line = page.getByText('An operator took a and b apart.').first();
  await line.waitFor();
  await page.reload();
  await page.getByRole('tab', { name: /Events/ }).click();
  await line.waitFor();
  await page.getByText('a and b are merged.').first().waitFor();
  assert.equal(await page.getByText('withdrawn').count(), 0, 'what an operator took apart is no alarm');
  await picture(page, 'events');
  await audit(page);
  clean(page);
});

test('the session that is asked for merges goes through the dialog too', async () => {
  await press('Merge now');
  await agree('Merge now');
  await page.getByText('The server looks for merges.', { exact: false }).waitFor();
  clean(page);
});

test('an export opens and has as many points as it says', async () => {
  await press('Export');
  await page.locator('#export-progress').waitFor({ state: 'attached' });
  await page.evaluate(() => {
    window.progress = [];
    const words = document.querySelector('#export-progress output');
    new MutationObserver(() => window.progress.push(words.value)).observe(words, { childList: true, characterData: true, subtree: true });
  });
  const download = page.waitForEvent('download');
  await agree('Export');
  const file = join(scratch, 'map.ply');
  await (await download).saveAs(file);
  const bytes = readFileSync(file);
  const end = bytes.indexOf('end_header\n') + 'end_header\n'.length;
  const header = bytes.subarray(0, end).toString('latin1');
  const sizes = { float: 4, double: 8, uchar: 1, ushort: 2, int: 4, uint: 4 };
  const stride = [...header.matchAll(/^property (\w+) /gm)].reduce((sum, [, type]) => sum + sizes[type], 0);
  const vertices = Number(/^element vertex (\d+)$/m.exec(header)[1]);
  assert.ok(vertices > 1000, header);
  assert.equal((bytes.length - end) / stride, vertices);
  const progress = await page.evaluate(() => window.progress);
  assert.equal(progress[0], 'The server counts the points…');
  assert.equal(progress.at(-1), `100\u202f% of ${(bytes.length / 1e6).toFixed(1)} MB`);
  const component = (await station.json('api/v1/atlas')).components[0].id;
  const whole = await (await fetch(`${station.url}api/v1/export?component=${component}&format=ply&voxel=0.1`)).arrayBuffer();
  assert.equal(Buffer.compare(Buffer.from(whole), bytes), 0, 'the file is what the server sent');
  clean(page);
});

test('an export that is cancelled ends, and leaves no file', async () => {
  const saved = [];
  page.on('download', (download) => saved.push(download.suggestedFilename()));
  await page.route('**/api/v1/export?*', () => {}); // a server that counts for long
  await press('Export');
  const ended = page.waitForEvent('requestfailed', (request) => request.url().includes('/api/v1/export'));
  await agree('Export');
  await page.getByText('The server counts the points…').waitFor();
  await agree('Cancel');
  await ended;
  await closed();
  await page.unroute('**/api/v1/export?*');
  assert.deepEqual(saved, []);
  clean(page);
});

test('a plan from above is a page to scale', async () => {
  for (const [format, begins] of [['pdf', '%PDF-'], ['svg', '<?xml'], ['png', '\x89PNG']]) {
    await press('Export');
    await page.locator('select[name=format]').selectOption(format);
    await page.locator('select[name=scale]').selectOption('500');
    const download = page.waitForEvent('download');
    await agree('Export');
    const file = join(scratch, `plan.${format}`);
    await (await download).saveAs(file);
    assert.equal(readFileSync(file).subarray(0, begins.length).toString('latin1'), begins);
    await closed();
  }
  assert.match(readFileSync(join(scratch, 'plan.svg'), 'utf8'), />1:500</);
  clean(page);
});

test('an export that the server can not give says why, and nothing goes on', async () => {
  await page.route('**/api/v1/export?*', (route) => route.fulfill({ status: 400, json: { error: { message: 'no such thing' } } }));
  page.allowed = /400 \(Bad Request\)/;
  await press('Export');
  await agree('Export');
  await page.getByRole('dialog').getByText('no such thing').waitFor();
  assert.ok(!(await page.locator('#export-progress').isVisible()));
  await agree('Cancel');
  await page.unroute('**/api/v1/export?*');
  clean(page);
});

test('a session gets a name and its map another anchor; both are taken back with one click', async () => {
  const undo = () => page.locator('.toast-offer').last().click();
  const label = async () => (await station.json('api/v1/sessions')).sessions.find(({ robot }) => robot === 'b').label;
  await page.locator('.robot-head:has(.robot-name:text-is("b"))').click();
  await press('Rename…');
  await page.locator('input[name=name]').fill('Drift 7, east');
  await agree('Rename');
  await page.locator('.robot-name', { hasText: 'Drift 7, east' }).waitFor();
  assert.equal(await label(), 'Drift 7, east');
  await undo();
  await until('no name', async () => (await label()) === null);

  const anchor = async () => (await station.json('api/v1/atlas')).components[0].anchor.robot;
  assert.equal(await anchor(), 'a');
  await press('Anchor here…');
  await agree('Anchor');
  await until('the other anchor', async () => (await anchor()) === 'b');
  await undo();
  await until('the first anchor', async () => (await anchor()) === 'a');
  clean(page);
});

test('a merge that was withdrawn stays over the page until somebody has seen it', async () => {
  const { id, a, b } = await alignment();
  const withdrawn = { id: 900, at_s: Date.now() / 1000, kind: 'withdrawn', text: `The merge of ${a.robot}/${a.session} and ${b.robot}/${b.session} was withdrawn: other sessions contradict it. The robots were told.`, session_id: null, alignment_id: id };
  const alarmed = await open(browser, station.url, { before: (opened) => opened.route('**/api/v1/log?*', (route) => route.fulfill({ json: { entries: [withdrawn] } })) });
  await alarmed.getByRole('alert').getByText('The merge of a and b was withdrawn: other sessions contradict it.').waitFor();
  await picture(alarmed, 'withdrawn');
  await audit(alarmed);
  await alarmed.reload();
  await alarmed.getByRole('button', { name: 'Why', exact: true }).click();
  await alarmed.getByText('What was measured').waitFor();
  await alarmed.getByRole('button', { name: 'Seen', exact: true }).click();
  await until('no alarm', async () => (await alarmed.getByRole('alert').filter({ hasText: 'withdrawn' }).count()) === 0);
  await alarmed.reload();
  await alarmed.getByText('Live', { exact: true }).waitFor();
  assert.equal(await alarmed.getByRole('alert').filter({ hasText: 'withdrawn' }).count(), 0);
  clean(alarmed);
  await alarmed.context().close();
});

const surveys = async () => (await station.json('api/v1/survey')).surveys;
const place = () => press('Place in the mine grid');

async function paste(lines) {
  if (!(await page.locator('.survey textarea').isVisible())) await page.getByText('Paste lines').click();
  await page.locator('.survey textarea').fill(lines.join('\n'));
  await press('Take over');
}

test('control points place a session in the mine grid; too few are refused where they were typed', async () => {
  await press('Survey…');
  await paste(['point;x;y;z;east;north;height', 'S1;0;0;0;1000;2000;-400', 'S2;10;0;0;1000;2010,1;-400']);
  await until('two rows', async () => (await page.locator('.control').count()) === 2);
  await place();
  await page.getByText('Three control points are needed; there are 2.', { exact: false }).waitFor();
  await paste(['S3, 0, 10, 0, 990, 2000, -400']);
  await place();
  await page.getByText(/The points fit within \d+\.\d cm \(rms\); the worst is S2, off by [5-9]\.\d cm\./).first().waitFor();
  const [survey] = await surveys();
  const at_m = [3, 7, 11].map((at) => Math.round(survey.T_grid_session[at]));
  assert.deepEqual(at_m, [1000, 2000, -400]);
  await page.locator('.label-control', { hasText: 'S2' }).waitFor({ state: 'attached' });
  await page.locator('.robot-open .facts', { hasText: 'surveyed' }).waitFor();
  await picture(page, 'surveyed');
  await audit(page);
  await page.locator('.toast-offer').last().click();
  await until('no survey', async () => (await surveys()).length === 0);
  clean(page);
});

test('a point that does not fit the others is named, and placed only when it is said to be right', async () => {
  page.allowed = /403 \(Forbidden\)/;
  const fill = (name, value) => page.getByLabel(name, { exact: true }).fill(value);
  for (const [name, value] of Object.entries({ 'East of S2 in the mine grid': '1000', 'North of S2 in the mine grid': '2010', 'Height of S2 in the mine grid': '-400' })) await fill(name, value);
  await paste(['S4 -10 -10 0 1010 1990 -398']);
  await place();
  await page.getByText(/S4 is likely wrong: .* put it 2\.00 m below/).waitFor();
  assert.equal((await surveys()).length, 0);
  await picture(page, 'blunder');
  await press('Place all the same');
  await page.locator('.control-suspect', { hasText: 'likely wrong' }).waitFor();
  await fill('Height of S4 in the mine grid', '-400');
  await place();
  await page.getByText(/The points fit within 0\.\d cm/).first().waitFor();
  assert.equal((await surveys())[0].suspect, null);
  await press('Pick on the map');
  await page.getByText('Click the next control point on the map.').waitFor();
  const stage = await page.locator('canvas').first().boundingBox();
  await until('a point that was picked', async () => {
    await page.locator('canvas').first().click({ position: elsewhere(stage), force: true });
    return (await page.locator('.control').count()) === 5;
  });
  assert.match(await page.getByLabel('x of P5 on the map').inputValue(), /^-?\d+\.\d{3}$/);
  await press('Remove P5');
  await press('Pick on the map');
  await page.getByRole('button', { name: 'Back', exact: true }).click();
  await page.locator('.label-control', { hasText: 'S4' }).waitFor({ state: 'attached' });
  await press('Survey…');
  await paste(['0 -1 0 500\n1 0 0 600\n0 0 1 7\n0 0 0 1']);
  await until('the transform itself', async () => (await surveys())[0].points.length === 0);
  assert.equal((await surveys())[0].T_grid_session[3], 500);
  await page.locator('.toast-offer').last().click();
  await until('the survey before it', async () => (await surveys())[0].points.length === 4);
  await page.getByRole('button', { name: 'Back', exact: true }).click();
  clean(page);
});

test('coordinates of a point are held by a click, in the mine grid too, and can be copied', async () => {
  await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
  const stage = await page.locator('canvas').first().boundingBox();
  const readout = page.locator('.readout');
  await until('a point that is held', async () => {
    await page.locator('canvas').first().click({ position: elsewhere(stage), force: true });
    return (await readout.getByRole('button', { name: 'Copy' }).isVisible()) && /z .* m in the frame of the map of 2 sessions\nE .* N .* H .* m in the mine grid/.test(await readout.locator('output').textContent());
  });
  await readout.getByRole('button', { name: 'Copy' }).click();
  await page.getByText('The coordinates were copied.').waitFor();
  const [east, north, height] = (await page.evaluate(() => navigator.clipboard.readText())).split('\t').map(Number);
  const words = (await readout.locator('output').textContent()).replaceAll('−', '-');
  const shown = words.match(/E (\S+) N (\S+) H (\S+) m/).slice(1).map(Number);
  // What is copied has millimetres, what is shown has centimetres.
  [east, north, height].forEach((copied, axis) => assert.ok(Math.abs(copied - shown[axis]) < 0.006, words));
  clean(page);
});

test('keys: views, colours, roof, measuring, and the way back', async () => {
  await page.locator('canvas').first().focus();
  await page.keyboard.press('t');
  await page.getByRole('button', { name: 'Free', pressed: true }).waitFor();
  await page.keyboard.press('c');
  await page.getByRole('button', { name: 'Height', pressed: true }).waitFor();
  await picture(page, 'free_height');
  await page.keyboard.press('t');
  await page.keyboard.press('f');
  await page.keyboard.press('m');
  await page.getByText('Click a point of the map', { exact: false }).waitFor();
  const stage = await page.locator('canvas').first().boundingBox();
  const labels = page.locator('.label-measure');
  // Over the map until both ends have been found.
  await until('two ends of a measurement', async () => {
    const at = elsewhere(stage);
    await page.locator('canvas').first().click({ position: at, force: true });
    return (await labels.count()) === 3;
  });
  assert.match(await labels.last().textContent(), /^\d+\.\d\d m · level \d+\.\d\d m · height [+−]\d+\.\d\d m$/);
  await picture(page, 'measured');
  await page.keyboard.press('Escape');
  await until('no measurement', async () => (await labels.count()) === 0);
  await page.keyboard.press('?');
  await page.getByRole('dialog', { name: 'Keys' }).waitFor();
  await page.keyboard.press('Escape');
  await closed();
  clean(page);
});

test('everything that can be pressed has a name, in both colours and on a tablet', async () => {
  const nameless = await page.evaluate(() =>
    [...document.querySelectorAll('button, input, select, [role=button]')]
      .filter((element) => !element.getAttribute('aria-label') && !element.textContent.trim() && !element.closest('label'))
      .map((element) => element.outerHTML),
  );
  assert.deepEqual(nameless, []);
  const tablet = await open(browser, station.url, { viewport: { width: 820, height: 1180 }, colorScheme: 'light' });
  await until('points', async () => (await shown(tablet)).points > 0);
  await tablet.locator('.robot').first().waitFor();
  assert.equal(await tablet.evaluate(() => document.documentElement.scrollWidth), 820, 'nothing hangs over');
  assert.equal(await tablet.evaluate(() => document.documentElement.dataset.theme), 'light');
  await picture(tablet, 'tablet_light');
  clean(tablet);
  await tablet.context().close();
});

test('on a phone the map comes first, and each panel is laid over it', async () => {
  for (const [width, height, least] of [[390, 844, 600], [844, 390, 250]]) {
    const phone = await open(browser, station.url, { viewport: { width, height }, hasTouch: true });
    await until('points', async () => (await shown(phone)).points > 0);
    const map = await phone.locator('canvas').first().boundingBox();
    assert.ok(map.height >= least && map.width === width, `the map is ${map.width} x ${map.height} on ${width} x ${height}`);
    assert.deepEqual(await phone.evaluate(() => [document.documentElement.scrollWidth, document.documentElement.scrollHeight]), [width, height], 'nothing hangs over');
    await picture(phone, `phone_${width}`);
    await audit(phone);
    const bar = phone.getByRole('navigation');
    for (const [name, inside] of [['Robots', '.robot'], ['Merges', '.pair'], ['Sessions', '.span'], ['Events', '.log li']]) {
      await bar.getByRole('button', { name, exact: true }).click();
      await phone.locator(inside).first().waitFor();
      const { x, y } = await phone.locator('.panel:visible').boundingBox();
      assert.ok(x > 0 || y > 0.25 * height, `${name} leaves some of the map`);
    }
    await picture(phone, `phone_${width}_events`);
    await audit(phone);
    await bar.getByRole('button', { name: 'Map', exact: true }).click();
    await until('the map alone', async () => (await phone.locator('.panel:visible').count()) === 0);
    clean(phone);
    await phone.context().close();
  }
});

test('after the server was killed the page comes back by itself, with all that it knew', async () => {
  const { http, robots } = station;
  const known = await shown(page);
  const again = await open(browser, station.url, { allowed: /ERR_CONNECTION_REFUSED|ERR_CONNECTION_RESET|ERR_EMPTY_RESPONSE|ERR_INCOMPLETE_CHUNKED_ENCODING|ERR_CONTENT_LENGTH_MISMATCH|WebSocket connection/ });
  await until('the map', async () => (await shown(again)).points > 0);
  await page.context().close();
  page = again;
  await station.kill();
  await page.getByText('Server away').waitFor();
  await picture(page, 'away');
  station = await Station.start(station.data, { http, robots });
  await page.getByText('Live', { exact: true }).waitFor();
  const all = known.keyframes.sort().join();
  await until('all keyframes', async () => (await shown(page)).keyframes.sort().join() === all); // paths come thinned at first
  await finished(station.replay('c', join(drives, 'c')));
  await until('a robot that came after it', async () => (await shown(page)).keyframes.length === 3);
  clean(page);
});

test('a wrong token is said to be wrong; the right one signs the browser in, and no script can read what it keeps', async () => {
  const guarded = await Station.start(join(scratch, 'guarded'), { insecure: false });
  const locked = await open(browser, guarded.url, { allowed: /401 \(Unauthorized\)/ });
  await locked.getByRole('dialog').getByRole('textbox').or(locked.locator('input[name=token]')).first().fill('not-the-token');
  clean(locked);
  await locked.getByRole('button', { name: 'Open' }).click();
  await locked.getByText("The server says: this is not the operator's token", { exact: false }).waitFor();
  await picture(locked, 'wrong_token');
  await audit(locked);
  await locked.locator('input[name=token]').fill(guarded.token);
  await locked.getByRole('button', { name: 'Open' }).click();
  await locked.getByText('Live', { exact: true }).waitFor();
  const kept = await locked.evaluate(() => JSON.stringify([sessionStorage, localStorage, document.cookie]));
  assert.ok(!kept.includes(guarded.token) && !kept.includes('headframe-'), kept);
  const [cookie] = await locked.context().cookies();
  assert.deepEqual([cookie.httpOnly, cookie.sameSite, cookie.expires, cookie.value === guarded.token], [true, 'Strict', -1, false]);
  const beside = await locked.context().newPage();
  await beside.goto(guarded.url);
  await beside.getByText('Live', { exact: true }).waitFor();
  await beside.close();
  assert.ok(!locked.url().includes(guarded.token));
  await locked.getByRole('button', { name: 'Invite a robot…' }).click();
  await locked.locator('input[name=robot]').fill('r1');
  await agreeOn(locked, 'Invite');
  await locked.getByText('r1 is invited').waitFor();
  await locked.getByText(/It is good until \d\d:\d\d, for an hour/).waitFor();
  await locked.getByText(`headframe-replay --server ${guarded.robots} --robot r1 --enrol `, { exact: false }).waitFor();
  assert.ok(guarded.process.text.includes(`operators: ${guarded.url}, with the token in ${join(guarded.data, 'operator.token')}`), guarded.process.text);
  await agreeOn(locked, 'Close');
  await locked.getByText('Who may come in').click();
  await locked.getByText(/invited, its code is good until/).waitFor();
  await locked.getByRole('button', { name: 'Rate…' }).click();
  await locked.locator('input[name=rate]').fill('64');
  await agreeOn(locked, 'Set');
  await locked.getByText('sends 64 KiB/s at most').waitFor();
  await locked.getByRole('button', { name: 'Revoke…' }).click();
  await agreeOn(locked, 'Revoke');
  await locked.getByText('revoked: it can not come in').waitFor();
  await picture(locked, 'fleet');
  await audit(locked);
  await locked.getByRole('button', { name: 'Sign out' }).click();
  await locked.locator('input[name=token]').waitFor();
  assert.deepEqual(await locked.context().cookies(), []);
  clean(locked);
  await locked.context().close();
  await guarded.kill();
});

const agreeOn = (opened, name) => opened.getByRole('dialog').getByRole('button', { name, exact: true }).click();

test('a robot that keeps its clouds back is asked for them', async () => {
  const thin = await Station.start(join(scratch, 'thin'));
  const asking = await open(browser, thin.url);
  const careful = thin.replay('careful', join(drives, 'short_0'), ['--fast', '--clouds', 'on_request', '--linger', '120']);
  await asking.locator('.robot-head', { hasText: 'careful' }).click();
  await asking.getByRole('button', { name: 'Request clouds…' }).click();
  await agreeOn(asking, 'Request clouds');
  await asking.getByText('careful was asked for its clouds.', { exact: true }).waitFor();
  await until('the clouds', async () => {
    const [row] = (await thin.json('api/v1/sessions')).sessions;
    return row.clouds > 0 && row.clouds === row.keyframes;
  });
  // It stays connected: out of sight its name stands at the edge, and a click goes there.
  await asking.locator('canvas').first().focus();
  for (let at = 0; at < 12; at++) await asking.keyboard.press('ArrowRight');
  await asking.locator('button.label-robot[data-off]', { hasText: 'careful' }).click();
  await asking.locator('button.label-robot:not([data-off])', { hasText: 'careful' }).waitFor();
  clean(asking);
  careful.kill();
  await asking.context().close();
  await thin.kill();
});

test('fifty robots fit on the page', async () => {
  const config = join(scratch, 'many.toml');
  writeFileSync(config, '[merge]\nleast_path_m = 1000\n');
  const many = await Station.start(join(scratch, 'many'), { more: ['--config', config] });
  const names = Array.from({ length: 50 }, (_, index) => index);
  for (let at = 0; at < names.length; at += 10)
    await Promise.all(names.slice(at, at + 10).map((index) => finished(many.replay(`robot-${index}`, join(drives, `short_${index}`)))));
  const crowd = await open(browser, many.url);
  await until('all fifty', async () => (await shown(crowd)).keyframes.length === 50);
  await until('their points', async () => (await shown(crowd)).points > 5000);
  await until('all fifty in the list', async () => (await crowd.locator('.robot').count()) === 50);
  assert.ok((await shown(crowd)).points <= mostPoints);
  await crowd.getByRole('button', { name: 'Measure' }).click();
  const [crowded, said] = [await crowd.locator('canvas').first().boundingBox(), crowd.locator('.tools-measure output')];
  const wanted = [/^No point of a map is there/, /not merged: where they lie to each other is not known/];
  await until('a click on nothing, and a point of another map', async () => {
    await crowd.locator('canvas').first().click({ position: elsewhere(crowded), force: true });
    const words = await said.textContent();
    assert.doesNotMatch(words, /\d m · level/, 'no metres between maps that are not merged');
    const at = wanted.findIndex((pattern) => pattern.test(words));
    if (at >= 0) wanted.splice(at, 1);
    if ((await crowd.locator('.label-measure').count()) > 2) await crowd.getByRole('button', { name: 'Clear' }).click();
    return wanted.length === 0;
  });
  await crowd.keyboard.press('Escape');
  await picture(crowd, 'fifty');
  clean(crowd);
  await crowd.context().close();
  await many.kill();
});
