// Makes the pictures of the README anew: the mine of ./run demo, its three robots, the real server, a real browser.
//     HEADFRAME_BIN=$PWD/build/release/bin HEADFRAME_OUT=$PWD/server/operator/web/pictures node server/operator/web/pictures/make.mjs

import { join } from 'node:path';
import { finished, launch, needs, open, picture, scratchFolder, shown, start, Station, until } from '../tests/support.mjs';

const points = 600_000;
const driven = 22; // keyframes of the robot that is on its way in the first picture
const linger = ['--linger', '600'];

needs('headframe-demo', 'headframe-server', 'headframe-replay');
const scratch = scratchFolder();
await finished(start('headframe-demo', [], { cwd: scratch })); // digs the mine and drives
const drive = (robot) => join(scratch, 'build/demo/mine', robot);
const station = await Station.start(join(scratch, 'data'));
const browser = await launch();
const page = await open(browser, `${station.url}#points=${points}`, { viewport: { width: 1440, height: 860 }, colorScheme: 'dark' });
const merged = async () => Math.max(0, ...(await station.json('api/v1/atlas')).components.map(({ sessions }) => sessions.length));
const keyframes = async (robot) => (await station.json('api/v1/sessions')).sessions.find((session) => session.robot === robot)?.keyframes ?? 0;

/** No new points for a while: every level of detail for which there is room has come. */
async function settled() {
  let before = { points: -1, since: 0 };
  await until('all points', async () => {
    const now = (await shown(page)).points;
    if (now !== before.points) before = { points: now, since: Date.now() };
    return Date.now() - before.since > 4000;
  });
}

for (const robot of ['scout', 'mapper']) station.replay(robot, drive(robot), ['--fast', ...linger]);
await until('two maps that are merged', async () => (await merged()) === 2);
await settled();
station.replay('hauler', drive('hauler'), ['--rate', '3', ...linger]);
await until('a robot on its way', async () => (await keyframes('hauler')) >= driven);
await picture(page, 'driving');
await until('three maps that are merged', async () => (await merged()) === 3);
await page.getByText('3 of 3', { exact: false }).first().waitFor();
await settled();
await picture(page, 'merged');
await page.locator('.pair').first().click();
await page.locator('.histogram rect').first().waitFor();
await page.getByText('What was measured').waitFor();
await settled();
await picture(page, 'evidence');
process.exit(0);
