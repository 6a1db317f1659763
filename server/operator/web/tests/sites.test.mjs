// Two mines on one server: what is said to be of another site comes apart, and the page looks at one of them.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { auditWidths, browserAndStation, endAll, finished, needs, open, picture, scratchFolder, start, until } from './support.mjs';

needs('headframe-server', 'headframe-replay', 'headframe-drawn-sessions');
const scratch = scratchFolder();
let browser;
let station;

before(async () => {
  [browser, station] = await browserAndStation(scratch, { insecure: false });
});

after(async () => {
  await browser?.close();
  endAll();
});

async function enrolAndReplay(robot) {
  const { enrolment } = await station.json(`api/v1/robots/add?robot=${robot}`, 'POST');
  const credential = ['--credential', join(scratch, `${robot}.credential`)];
  await finished(start('headframe-replay', ['--server', station.robots, '--robot', robot, '--enrol', enrolment, ...credential, '--fast', join(scratch, 'drives', robot)]));
}

test('a session is taken to another site, and what its robot begins goes there', async () => {
  for (const robot of ['a', 'b']) await enrolAndReplay(robot);
  const components = async () => (await station.json('api/v1/atlas?wait=60')).components.length;
  assert.equal(await components(), 1, 'they are merged');
  const page = await open(browser, station.url, { token: station.token });
  const names = () => page.locator('.robot-name').allTextContents();
  const site = page.getByLabel('Site', { exact: true });
  await until('both', async () => (await names()).length === 2);
  assert.equal(await site.count(), 0, 'there is one mine');

  await page.locator('.robot-head:has(.robot-name:text-is("b"))').click();
  await page.locator('.robot-open').getByRole('button', { name: 'Site…' }).click();
  await page.locator('input[name=site]').fill('North shaft');
  await page.getByRole('dialog').getByRole('button', { name: 'Set' }).click();
  await page.getByText('b is of the site North shaft.').waitFor();
  assert.equal(await components(), 2);
  await site.waitFor();
  await auditWidths(page, 'sites');
  await site.selectOption({ label: 'North shaft' });
  await until('its robot alone', async () => JSON.stringify(await names()) === '["b"]');
  await until('its map alone', () => page.evaluate(() => window.headframe.shown.keyframes.size === 1));
  await picture(page, 'one_site');
  await page.reload();
  await until('that choice is kept', async () => JSON.stringify(await names()) === '["b"]');
  await site.selectOption({ label: 'No site' });
  await until('the others alone', async () => JSON.stringify(await names()) === '["a"]');
  await site.selectOption({ label: 'All sites' });
  await until('both again', async () => (await names()).length === 2);

  await page.getByText('Who may come in').click();
  const row = page.locator('.fleet-row:has(strong:text-is("a"))');
  await row.getByRole('button', { name: 'Site…' }).click();
  await page.locator('input[name=site]').fill('a/b');
  await page.getByRole('dialog').getByRole('button', { name: 'Set' }).click();
  assert.equal(await page.getByRole('dialog').count(), 1, 'no name holds a slash');
  await page.locator('input[name=site]').fill('North shaft');
  await page.getByRole('dialog').getByRole('button', { name: 'Set' }).click();
  await row.getByText('drives at North shaft').waitFor();
  const { sites } = await station.json('api/v1/sites');
  assert.deepEqual(
    sites.map(({ site, robots, sessions }) => [site, robots, sessions.length]),
    [
      [null, [], 1],
      ['North shaft', ['a'], 1],
    ],
  );
  assert.deepEqual(page.faults, []);
});
