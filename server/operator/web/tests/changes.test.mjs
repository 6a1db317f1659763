// A mine that was worked on between two sessions: what changed is on the map and in a list.

import assert from 'node:assert/strict';
import { mkdirSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { auditWidths, endAll, finished, launch, needs, open, outputs, picture, scratchFolder, shown, start, Station, until } from './support.mjs';

needs('headframe-server', 'headframe-replay', 'headframe-drawn-sessions');
const scratch = scratchFolder();
const drives = join(scratch, 'drives');
const known = 'No change of the mine is known.';
let browser;
let station; // its pair is not merged before the second test
let page;

before(async () => {
  mkdirSync(outputs, { recursive: true });
  await finished(start('headframe-drawn-sessions', [drives]));
  [browser, station] = [await launch(), await Station.start(join(scratch, 'data'))];
  for (const robot of ['before', 'after']) await finished(station.replay(robot, join(drives, robot)));
  await station.json('api/v1/atlas?wait=60');
  page = await open(browser, station.url);
  await until('points', async () => (await shown(page)).points > 0);
});

after(async () => {
  await browser?.close();
  endAll();
});

const press = (name) => page.getByRole('button', { name, exact: true }).click();
const ring = () => page.getByRole('button', { name: /^Change: excavated, / });
const onMap = async (wanted) => until(`${wanted} rings`, async () => (await ring().count()) === wanted);
const since = (day) => page.getByLabel('Changes that may have come after this day').fill(day);

test('before the sessions are merged no change is known, and the list says what would tell of one', async () => {
  await page.getByRole('tab', { name: 'Changes' }).click();
  await page.getByText(known).waitFor();
  assert.equal(await page.getByRole('button', { name: 'Changes', exact: true }).count(), 0, 'no layer without anything in it');
});

test('as soon as they are merged the change is drawn where it is, and listed with kind, size and dates', async () => {
  const [{ id }] = (await station.json('api/v1/alignments')).alignments;
  await station.json(`api/v1/alignments/${id}/confirm`, 'POST');
  await page.locator('.change').waitFor();
  const { changes } = await station.json('api/v1/changes');
  assert.equal(changes.length, 1);
  const words = await page.locator('.change').textContent();
  for (const part of ['excavated', changes[0].size_m.map((metres) => metres.toFixed(1)).join(' × '), '14 Nov 2023', '14 Dec 2023', 'before', 'after', `x ${changes[0].p[0].toFixed(1)}`]) assert.ok(words.includes(part), `${part} is in: ${words}`);
  await onMap(1);
  await picture(page, 'changes');
  // A click in the list goes there, and the ring's name is in the middle of the map.
  await page.locator('.change-name').click();
  const stage = await page.locator('canvas').first().boundingBox();
  await until('the change in the middle', async () => {
    const { x, y, width, height } = await ring().boundingBox();
    return Math.abs(x + width / 2 - stage.x - stage.width / 2) < 4 && Math.abs(y + height / 2 - stage.y - stage.height / 2) < 30;
  });
  await page.getByRole('tab', { name: 'Events' }).click();
  await ring().click();
  await page.locator('.change[data-chosen]').waitFor();
  await auditWidths(page, 'changes');
  assert.deepEqual(page.faults, []);
});

test('the layer is switched off and on, by its button and its key, and keeps to changes since a day', async () => {
  await press('Changes');
  await onMap(0);
  assert.equal(await page.getByLabel('Show changes on the map').isChecked(), false);
  await page.locator('canvas').first().focus();
  await page.keyboard.press('d');
  await onMap(1);
  await since('2023-12-14');
  await onMap(1);
  assert.equal(await page.locator('.change').count(), 1, 'it may have come on that day');
  await since('2023-12-16');
  await onMap(0);
  await page.getByText('0 of 1', { exact: true }).waitFor();
  await since('');
  await onMap(1);
  assert.deepEqual(page.faults, []);
});

test('what was not seen yet at the moment that is shown is not drawn, and a merge taken apart takes its changes along', async () => {
  await press('Time');
  await page.getByRole('slider', { name: /Moment that is shown/ }).fill('0');
  await onMap(0);
  await press('Show all again');
  await onMap(1);
  const [{ id }] = (await station.json('api/v1/alignments')).alignments;
  await station.json(`api/v1/alignments/${id}/retract`, 'POST');
  await page.getByText(known).waitFor();
  await onMap(0);
  assert.deepEqual(page.faults, []);
});
