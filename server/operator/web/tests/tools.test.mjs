// What a surveyor does with a map of two sessions: goes back in time, cuts it, measures and writes beside it.

import assert from 'node:assert/strict';
import { mkdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { auditWidths, endAll, finished, launch, needs, open, outputs, picture, scratchFolder, shown, start, Station, until } from './support.mjs';

needs('headframe-server', 'headframe-replay', 'headframe-drawn-sessions');
const scratch = scratchFolder();
const drives = join(scratch, 'drives');
let browser;
let station;
let page;
const wholePaths = []; // that the page asked for

before(async () => {
  mkdirSync(outputs, { recursive: true });
  await finished(start('headframe-drawn-sessions', [drives]));
  [browser, station] = [await launch(), await Station.start(join(scratch, 'data'))];
  for (const robot of ['a', 'b']) await finished(station.replay(robot, join(drives, robot)));
  await until('a merge', async () => (await station.json('api/v1/alignments')).alignments[0]?.state === 'published');
  const before = (opened) => opened.on('response', (answer) => /trajectory\?from=1$/.test(answer.url()) && wholePaths.push(answer.url()));
  page = await open(browser, station.url, { before });
  const driven = (await station.json('api/v1/sessions')).sessions.reduce((sum, { keyframes }) => sum + keyframes, 0);
  await until('points, and every keyframe of both', async () => {
    const { points, keyframes } = await shown(page);
    return points > 0 && keyframes.reduce((sum, count) => sum + count, 0) === driven;
  });
});

after(async () => {
  await browser?.close();
  endAll();
});

const clean = () => assert.deepEqual(page.faults, []);
const press = (name) => page.getByRole('button', { name, exact: true }).click();
const lasts = async () => (await shown(page)).until;

test('the slider of time shows the map as it was, and playing goes on to its end', async () => {
  const all = await lasts();
  assert.deepEqual(wholePaths, [], 'a first look needs no whole path');
  await press('Time');
  await until('the whole paths of both, which came thinned', () => wholePaths.length === 2);
  const slider = page.getByRole('slider', { name: 'Moment that is shown of 2 sessions' });
  assert.deepEqual(await lasts(), all, 'at first all is shown');
  await slider.fill('0');
  await until('the beginning', async () => Math.min(...(await lasts())) <= 1);
  assert.equal(await page.locator('.label-verdict').count(), 0, 'nothing was merged then');
  await slider.fill('1000');
  await until('the middle', async () => (await lasts()).some((last, at) => last > 1 && last < all[at]));
  await picture(page, 'time');
  await page.getByLabel('Speed').selectOption('500');
  await press('Play');
  await until('the end', async () => String(await lasts()) === String(all));
  await page.getByRole('button', { name: 'Play', exact: true }).waitFor();
  await slider.fill('500');
  await press('Show all again');
  await until('all of it', async () => String(await lasts()) === String(all));
  clean();
});

test('one session alone is played while the other stays, and the view goes along with its robot', async () => {
  const all = await lasts();
  await page.locator('.robot-head:has(.robot-name:text-is("b"))').click();
  await press('Follow');
  await page.getByRole('button', { name: 'Following b' }).waitFor();
  await press('Time');
  const slider = page.getByRole('slider', { name: 'Moment that is shown of b' });
  const stage = await page.locator('canvas').first().boundingBox();
  for (const at of ['200', '1500']) {
    const earlier = String(await lasts());
    await slider.fill(at);
    await until('another moment', async () => String(await lasts()) !== earlier);
    await until('the robot in the middle', async () => {
      const { x, y, width } = await page.locator('.label', { hasText: /^b$/ }).boundingBox();
      return Math.abs(x + width / 2 - stage.x - stage.width / 2) < 3 && Math.abs(y - stage.y - stage.height / 2) < 40;
    });
  }
  assert.equal((await lasts()).filter((last, at) => last === all[at]).length, 1, 'the other session stays whole');
  await page.getByRole('button', { name: 'Following b' }).click();
  await until('nobody is followed', async () => (await page.getByRole('button', { name: 'Following b' }).count()) === 0);
  await press('Show all again');
  await page.locator('canvas').first().focus();
  await page.keyboard.press('Escape');
  await until('no session that is selected', async () => (await page.locator('.robot-open').count()) === 0);
  clean();
});

test('sessions stand under the day on which they began, and ages have their dates', async () => {
  await page.getByRole('tab', { name: 'Sessions' }).click();
  await until('both sessions', async () => (await page.locator('.span').count()) === 2);
  await press('Age');
  await page.locator('.legend').getByText(/first seen|\d\d:\d\d/).first().waitFor();
  await picture(page, 'ages');
  await press('Robot');
  clean();
});

// Places on the canvas that fill its middle evenly, one after another (the sequence of Halton in bases 2 and 3).
const halton = (index, base) => (index === 0 ? 0 : (index % base) / base + halton(Math.floor(index / base), base) / base);
const canvas = () => page.locator('canvas').first();

test('a section along a line shows its points, which can be taken home and cut out', async () => {
  await press('Show all');
  await press('Measure');
  await press('Section');
  const { width, height } = await canvas().boundingBox();
  await canvas().click({ position: { x: 0.15 * width, y: 0.25 * height }, force: true });
  await page.getByText('Now the second point.').waitFor();
  await canvas().click({ position: { x: 0.85 * width, y: 0.7 * height }, force: true });
  const profile = page.getByRole('group', { name: 'Section', exact: true });
  await page.getByRole('slider', { name: 'Width of the section' }).fill('20');
  await profile.getByText(/\d m long, heights from -?\d+\.\d\d to -?\d+\.\d\d m/).waitFor();
  const length_m = Number(/([\d.]+) m long/.exec(await profile.locator('output').textContent())[1]);
  const saved = page.waitForEvent('download');
  await profile.getByRole('button', { name: 'CSV' }).click();
  const file = join(scratch, 'section.csv');
  await (await saved).saveAs(file);
  const [titles, ...lines] = readFileSync(file, 'utf8').trim().split('\n');
  assert.equal(titles, 'along_m,height_m,session,x_m,y_m,z_m');
  assert.ok(lines.length > 100, `${lines.length} points`);
  for (const line of lines) assert.ok(Number(line.split(',')[0]) <= length_m + 0.01 && ['a', 'b'].includes(line.split(',')[2]), line);
  await press('Time');
  await auditWidths(page, 'section', '.tools-bottom, .tools-measure');
  await press('Show all again');
  await press('Cut out');
  await page.getByRole('button', { name: /^Only \d+\.\d × 20\.0 m$/ }).waitFor();
  await picture(page, 'cut_out');
  await press('Clear');
  await until('no profile', async () => (await profile.count()) === 0);
  clean();
});

test('a clip box hides what lies outside, also from clicks, until all is shown again', async () => {
  await page.getByRole('button', { name: /^Only / }).click();
  await press('Distance');
  const { width, height } = await canvas().boundingBox();
  const labels = page.locator('.label-measure');
  let looked = 0;
  let met;
  await until('a point of the map', async () => {
    met = { x: width * (0.1 + 0.8 * halton(++looked, 2)), y: height * (0.25 + 0.4 * halton(looked, 3)) };
    await canvas().click({ position: met, force: true });
    return (await labels.count()) > 0;
  });
  await press('Clear');
  await press('Clip');
  const corner = met.y < 0.4 * height ? { x: 4, y: 0.6 * height } : { x: 4, y: 0.3 * height };
  await canvas().click({ position: corner, force: true });
  await page.getByText('Now the opposite corner.').waitFor();
  await canvas().click({ position: { x: 24, y: corner.y + 20 }, force: true });
  await page.getByRole('button', { name: /^Only / }).waitFor();
  await press('Distance');
  await canvas().click({ position: met, force: true });
  await page.getByText('No point of a map is there', { exact: false }).waitFor();
  await page.getByRole('button', { name: /^Only / }).click();
  await until('the point again', async () => {  // it is drawn a moment later
    await canvas().click({ position: met, force: true });
    return (await labels.count()) > 0;
  });
  await canvas().focus();
  await page.keyboard.press('Escape');
  clean();
});

test('what was measured is saved for others, who see it at once; and it can be taken away', async () => {
  const other = await open(browser, station.url);
  await other.getByText('Live', { exact: true }).waitFor();
  await other.getByRole('tab', { name: 'Notes' }).click();
  await other.getByText('Nothing is written on the map yet.').waitFor();
  await press('Measure');
  await press('Distance');
  const { width, height } = await canvas().boundingBox();
  let looked = 0;
  await until('two ends of a measurement', async () => {
    await canvas().click({ position: { x: width * (0.1 + 0.8 * halton(++looked, 2)), y: height * (0.25 + 0.4 * halton(looked, 3)) }, force: true });
    return (await page.locator('.label-measure').count()) === 3;
  });
  await press('Save…');
  await page.locator('input[name=text]').fill('Width of the drift');
  await page.getByRole('dialog').getByRole('button', { name: 'Save', exact: true }).click();
  const figure = /^Width of the drift · \d+\.\d\d m · level/;
  await other.locator('.notes .log-link', { hasText: figure }).waitFor();
  await other.locator('.label-note').waitFor({ state: 'attached' });
  await other.getByRole('tab', { name: 'Events' }).click();
  await other.getByLabel('Only what operators did').check();
  await other.getByText('An operator wrote a distance: "Width of the drift".').waitFor();
  assert.equal(await other.getByText('The server started.').count(), 0);
  await other.getByRole('tab', { name: 'Notes' }).click();
  await auditWidths(other, 'notes', '.side, .labels');
  await other.reload();
  await other.getByRole('tab', { name: 'Notes' }).click();
  await other.getByRole('button', { name: 'Take away…' }).click();
  await other.getByRole('dialog').getByRole('button', { name: 'Take away', exact: true }).click();
  await until('none on the other page', async () => (await page.locator('.label-note').count()) === 0);
  await other.locator('.toast-offer').click();
  await until('it again', async () => (await page.locator('.label-note').count()) === 1);
  assert.deepEqual(other.faults, []);
  await other.context().close();
  await canvas().focus();
  await page.keyboard.press('Escape');
  clean();
});

test('an operator with a name may do what the role says, until the token is revoked', async () => {
  const guarded = await Station.start(join(scratch, 'guarded'), { insecure: false });
  const enter = async (token) => {
    const opened = await open(browser, guarded.url, { allowed: /401 \(Unauthorized\)|WebSocket connection/, token });
    await opened.getByText('Live', { exact: true }).waitFor();
    return opened;
  };
  const owner = await enter(guarded.token);
  await owner.getByText('Operators', { exact: false }).first().click();
  await owner.getByRole('button', { name: 'Add an operator…' }).click();
  await owner.locator('input[name=name]').fill('vera');
  await owner.locator('select[name=role]').selectOption('view');
  await owner.getByRole('dialog').getByRole('button', { name: 'Add', exact: true }).click();
  const token = await owner.locator('.code').textContent();
  assert.match(token, /^[0-9a-f]{64}$/);
  await picture(owner, 'operator_added');
  await owner.getByRole('dialog').getByRole('button', { name: 'Close' }).click();
  await owner.locator('.fleet-row', { hasText: 'vera' }).getByText(/may look, until/).waitFor();
  await auditWidths(owner, 'people', 'html');
  const vera = await enter(token);
  await vera.getByText('vera, may look').waitFor();
  assert.equal(await vera.getByRole('button', { name: 'Merge now' }).count(), 0);
  assert.equal(await vera.getByText('Invite a robot').count(), 0);
  await owner.getByRole('button', { name: 'Revoke…' }).click();
  await owner.getByRole('dialog').getByRole('button', { name: 'Revoke', exact: true }).click();
  await vera.getByRole('dialog').getByText("this is not the operator's token", { exact: false }).waitFor();
  await owner.getByRole('tab', { name: 'Events' }).click();
  await owner.getByText('An operator revoked the token of vera.').waitFor();
  for (const opened of [owner, vera]) {
    assert.deepEqual(opened.faults, []);
    await opened.context().close();
  }
  await guarded.kill();
});
