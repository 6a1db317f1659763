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
  await picture(page, 'driving');
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
  await page.getByText('your decision was undone', { exact: false }).waitFor();
  await stateIs('published');

  await press('Take apart…');
  await agree('Take apart');
  await stateIs('retracted');
  await page.getByText('own frame, not merged').first().waitFor();
  await picture(page, 'apart');
  await press('Undo your decision');
  await stateIs('published');

  await press('Confirm…');
  await agree('Confirm');
  await until('the decision', async () => (await alignment()).decision === 'confirmed');
  await press('Undo your decision');
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
  await press('Undo your decision');
  await stateIs('published');
  await page.getByRole('tab', { name: /Events/ }).click();
  await page.getByText('You: a and b taken apart.').first().waitFor();
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

test('a plan from above is a picture', async () => {
  await press('Export');
  await page.getByLabel('Format').selectOption('png');
  const download = page.waitForEvent('download');
  await agree('Export');
  const file = join(scratch, 'plan.png');
  await (await download).saveAs(file);
  assert.equal(readFileSync(file).subarray(1, 4).toString(), 'PNG');
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

test('control points place a session in the mine grid; too few are refused where they were typed', async () => {
  const points = ['S1 0 0 0  1000 2000 -400', 'S2 10 0 0  1000 2010.1 -400', 'S3 0 10 0  990 2000 -400'];
  const surveys = async () => (await station.json('api/v1/survey')).surveys;
  await press('Survey…');
  await page.locator('textarea').fill(points.slice(0, 2).join('\n'));
  await agree('Place in the mine grid');
  await page.getByText('Three control points are needed; there are 2.').waitFor();
  await page.locator('textarea').fill(points.join('\n'));
  await agree('Place in the mine grid');
  await page.getByText(/The points fit within \d+\.\d cm \(rms\); the worst is S2, off by [5-9]\.\d cm\./).first().waitFor();
  const [survey] = await surveys();
  const at_m = [3, 7, 11].map((at) => Math.round(survey.T_grid_session[at]));
  assert.deepEqual(at_m, [1000, 2000, -400]);
  await page.locator('.toast-offer').last().click();
  await until('no survey', async () => (await surveys()).length === 0);

  await press('Survey…');
  await page.locator('textarea').fill(points.join('\n'));
  await agree('Place in the mine grid');
  await closed();
  await until('a survey', async () => (await surveys()).length === 1);
  await press('Survey…');
  assert.match(await page.locator('textarea').inputValue(), /^S1 0 0 0 1000 2000 -400\nS2 10 0 0 1000 2010.1 -400\n/, 'the survey that there is');
  await page.locator('textarea').fill('0 -1 0 500\n1 0 0 600\n0 0 1 7\n0 0 0 1');
  await agree('Place in the mine grid');
  await closed();
  await until('the transform itself', async () => (await surveys())[0].points.length === 0);
  assert.equal((await surveys())[0].T_grid_session[3], 500);
  await page.locator('.toast-offer').last().click();
  await until('the survey before it', async () => (await surveys())[0].points.length === 3);
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
    const at = { x: stage.width * (0.2 + 0.6 * Math.random()), y: stage.height * (0.25 + 0.5 * Math.random()) };
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

test('after the server was killed the page comes back by itself, with all that it knew', async () => {
  const { http, robots } = station;
  const known = await shown(page);
  const again = await open(browser, station.url, { allowed: /ERR_CONNECTION_REFUSED|ERR_CONNECTION_RESET|ERR_EMPTY_RESPONSE|ERR_INCOMPLETE_CHUNKED_ENCODING|WebSocket connection/ });
  await until('the map', async () => (await shown(again)).points > 0);
  await page.context().close();
  page = again;
  await station.kill();
  await page.getByText('Server away').waitFor();
  await picture(page, 'away');
  station = await Station.start(station.data, { http, robots });
  await page.getByText('Live', { exact: true }).waitFor();
  assert.deepEqual((await shown(page)).keyframes.sort(), known.keyframes.sort());
  await finished(station.replay('c', join(drives, 'c')));
  await until('a robot that came after it', async () => (await shown(page)).keyframes.length === 3);
  clean(page);
});

test('a wrong token is said to be wrong; the right one opens the page and is forgotten with the tab', async () => {
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
  assert.equal(await locked.evaluate(() => sessionStorage.length), 1);
  assert.ok(!(await locked.evaluate(() => JSON.stringify(localStorage))).includes(guarded.token));
  assert.ok(!locked.url().includes(guarded.token));
  await locked.getByRole('button', { name: 'Invite a robot…' }).click();
  await locked.locator('input[name=robot]').fill('r1');
  await agreeOn(locked, 'Invite');
  await locked.getByText('r1 is invited').waitFor();
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
  await picture(crowd, 'fifty');
  clean(crowd);
  await crowd.context().close();
  await many.kill();
});
