// A robot that is carried elsewhere while it drives: from the jump on it is another session, before everybody's eyes.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { browserAndStation, endAll, finished, needs, open, scratchFolder, shown, until } from './support.mjs';

needs('headframe-server', 'headframe-replay', 'headframe-drawn-sessions');
const scratch = scratchFolder();
let browser;
let station;

before(async () => {
  [browser, station] = await browserAndStation(scratch);
});

after(async () => {
  await browser?.close();
  endAll();
});

test('what was drawn beyond the jump leaves the session that ended there', async () => {
  const page = await open(browser, station.url);
  const drive = station.replay('ant', join(scratch, 'drives', 'carried'), ['--rate', '20']);
  await until('its first keyframes', async () => (await shown(page)).keyframes[0] > 3);
  await finished(drive);
  const rows = async () => (await station.json('api/v1/sessions')).sessions;
  await until('two sessions', async () => (await rows()).length === 2);
  await station.json('api/v1/atlas?wait=60');
  const [whole, part] = (await rows()).sort((x, y) => x.id - y.id);
  assert.equal(part.session, `${whole.session}~${whole.keyframes + 1}`);
  const both = [whole.keyframes, part.keyframes].sort();
  await until('each with its own keyframes', async () => JSON.stringify((await shown(page)).keyframes.sort()) === JSON.stringify(both));
  const anew = await open(browser, station.url);
  await until('the same points for who comes later', async () => (await shown(anew)).points === (await shown(page)).points);
  assert.deepEqual((await shown(anew)).keyframes.sort(), both);
  await page.locator('.robot-head').last().click();
  await page.getByText(`from keyframe ${whole.keyframes + 1} on it is session ${part.session}`).waitFor();
  assert.deepEqual(page.faults, []);
});
