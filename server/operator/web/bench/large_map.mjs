// A map of more than ten million points: what the page keeps, draws and costs.

import { until } from '../tests/support.mjs';
import { firstPicture, openPage, quantile, residentMb } from './measure.mjs';

/** Such a map: what each robot sends; and a laptop's budget of points. */
export const large = { clouds: 56, points_a_cloud: 9600, kept: 6_000_000, drawn: 3_000_000 };
const moves = 120; // of the hand that drags the map

/** Drags the map to and fro, and gives every frame that was timed: points drawn, and until the graphics card was done with it. */
async function framesOfADrag(page) {
  const stage = await page.locator('canvas').first().boundingBox();
  const [x, y] = [stage.x + stage.width / 2, stage.y + stage.height / 2];
  await page.evaluate(() => {
    window.timed = [];
    const look = () => {
      const { drawn, frame_ms } = window.headframe.shown;
      if (window.timed.at(-1)?.frame_ms !== frame_ms) window.timed.push({ drawn, frame_ms });
      requestAnimationFrame(look);
    };
    look();
  });
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let at = 0; at < moves; at++) await page.mouse.move(x + 60 * Math.sin(at / 8), y + 40 * Math.cos(at / 5));
  await page.mouse.up();
  return (await page.evaluate(() => window.timed)).slice(1); // the first one was before
}

/** The frames of a drag, before and after the view has found out how much it can draw. */
function dragFigures(frames) {
  const late = frames.slice(frames.length >> 1);
  return {
    most_drawn: Math.max(...frames.map(({ drawn }) => drawn)),
    first_frames_ms: frames.slice(0, 3).map(({ frame_ms }) => frame_ms),
    settled_drawn: quantile(late.map(({ drawn }) => drawn), 0.5),
    settled_frame_p50_ms: quantile(late.map(({ frame_ms }) => frame_ms), 0.5),
    settled_frame_p95_ms: quantile(late.map(({ frame_ms }) => frame_ms), 0.95),
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
async function finestPoints(server) {
  let points = 0;
  for (const { id } of await server.sessions()) {
    const answer = await fetch(`${server.url}api/v1/sessions/${id}/points?level=4&most=10000000`, { headers: { Authorization: `Bearer ${server.token}` } });
    const data = new DataView(await answer.arrayBuffer());
    for (let at = 0; at < data.byteLength; at += 20 + 6 * data.getUint32(at + 4, true)) points += data.getUint32(at + 4, true);
  }
  return points;
}

/** A map of more than 10 million points, which no longer grows: as a laptop's page loads it, and as one without a graphics card. */
export async function largeMap(browser, server) {
  const found = { server_before_mb: residentMb(server.pid) };
  const page = await openPage(browser, server, `#points=${large.kept}`);
  await page.evaluate(() => performance.setResourceTimingBufferSize(100_000));
  found.first_picture_ms = await firstPicture(page);
  const begun = Date.now();
  found.points_kept = await settledPoints(page);
  found.loaded_after_s = (Date.now() - begun) / 1000 - 5;
  found.bytes_received = await page.evaluate(() => performance.getEntriesByType('resource').reduce((sum, { transferSize }) => sum + transferSize, 0));
  Object.assign(found, await pageMemoryMb(browser), { server_after_mb: residentMb(server.pid) });
  found.drag = dragFigures(await framesOfADrag(page));
  await page.context().close();
  const modest = await openPage(browser, server);
  found.modest = { first_picture_ms: await firstPicture(modest), points_kept: await settledPoints(modest) };
  found.modest.drag = dragFigures(await framesOfADrag(modest));
  await modest.context().close();
  found.map_points = await finestPoints(server);
  return found;
}
