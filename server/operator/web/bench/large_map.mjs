// A map of more than ten million points: what the page keeps, draws and costs.

import { until } from '../tests/support.mjs';
import { firstPicture, openPage, quantile, residentMb } from './measure.mjs';

/** Such a map: what each robot sends; and a laptop's budget of points. */
export const large = { clouds: 60, points_a_cloud: 10_200, kept: 6_000_000, drawn: 3_000_000 };
const moves = 120; // of the hand that drags the map

/** From now on keeps the most points that any frame had, and each frame that was timed. */
const watchFrames = (page) =>
  page.evaluate(() => {
    window.frames = { most_drawn: 0, timed: [] };
    const look = () => {
      const { drawn, frame_ms } = window.headframe.shown;
      window.frames.most_drawn = Math.max(window.frames.most_drawn, drawn);
      if (window.frames.timed.at(-1)?.frame_ms !== frame_ms) window.frames.timed.push({ drawn, frame_ms });
      requestAnimationFrame(look);
    };
    look();
  });

/** Drags the map to and fro: the frames of it, once the view has found out how much it can draw. */
async function drag(page) {
  const stage = await page.locator('canvas').first().boundingBox();
  const [x, y] = [stage.x + stage.width / 2, stage.y + stage.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.evaluate(() => (window.frames.timed.length = 0));
  for (let at = 0; at < moves; at++) await page.mouse.move(x + 60 * Math.sin(at / 8), y + 40 * Math.cos(at / 5));
  const { most_drawn, timed } = await page.evaluate(() => window.frames);
  await page.mouse.up();
  const late = timed.slice(timed.length >> 1);
  const times = late.map(({ frame_ms }) => frame_ms);
  return {
    most_drawn,
    first_frames: timed.slice(0, 6),
    drawn_while_dragged: quantile(late.map(({ drawn }) => drawn), 0.5),
    frame_p50_ms: quantile(times, 0.5),
    frame_p95_ms: quantile(times, 0.95),
  };
}

/** No new points for a while, and how many there are. */
async function settledPoints(page) {
  let before = { points: -1, since: 0 };
  return until('all points for which there is room', async () => {
    const { points } = await page.evaluate(() => window.headframe.shown);
    if (points !== before.points) before = { points, since: Date.now() };
    return Date.now() - before.since > 5000 && points;
  });
}

async function pageMemoryMb(browser) {
  const { processInfo } = await (await browser.newBrowserCDPSession()).send('SystemInfo.getProcessInfo');
  const largest = (type) => Math.max(...processInfo.filter((one) => one.type === type).map(({ id }) => residentMb(id)));
  return { renderer_mb: largest('renderer'), graphics_mb: largest('GPU') };
}

/** The finest level of every session, counted. */
async function finestPoints(station) {
  let points = 0;
  for (const { id } of (await station.json('api/v1/sessions')).sessions) {
    const answer = await fetch(`${station.url}api/v1/sessions/${id}/points?level=4&most=10000000`);
    const data = new DataView(await answer.arrayBuffer());
    for (let at = 0; at < data.byteLength; at += 20 + 6 * data.getUint32(at + 4, true)) points += data.getUint32(at + 4, true);
  }
  return points;
}

/** On a station without tokens that has just been started: as a laptop's page loads it, and as one without a graphics card. */
export async function largeMap(browser, station) {
  const serverMb = () => residentMb(station.process.pid);
  const server = { url: station.url, token: '' };
  const found = { server_before_mb: serverMb() };
  const page = await openPage(browser, server, `#points=${large.kept}`);
  await page.evaluate(() => performance.setResourceTimingBufferSize(100_000));
  found.first_picture_ms = await firstPicture(page);
  await watchFrames(page);
  const begun = Date.now();
  found.points_kept = await settledPoints(page);
  found.loaded_after_s = (Date.now() - begun) / 1000 - 5;
  found.bytes_received = await page.evaluate(() => performance.getEntriesByType('resource').reduce((sum, { transferSize }) => sum + transferSize, 0));
  Object.assign(found, await pageMemoryMb(browser), { server_after_mb: serverMb() });
  Object.assign(found, await drag(page));
  await page.context().close();
  const modest = await openPage(browser, server);
  found.software = { first_picture_ms: await firstPicture(modest), points_kept: await settledPoints(modest) };
  await watchFrames(modest);
  Object.assign(found.software, await drag(modest));
  await modest.context().close();
  found.map_points = await finestPoints(station);
  return found;
}
