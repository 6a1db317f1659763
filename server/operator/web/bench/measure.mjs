// What all parts of the page's bench measure with.

import { readFileSync } from 'node:fs';
import { open, signIn } from '../tests/support.mjs';

const settle_ms = 1500; // a new window makes its own parts first

export const quantile = (values, share) => [...values].sort((x, y) => x - y)[Math.min(values.length - 1, Math.floor(share * values.length))];
export const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
export const residentMb = (pid) => (Number(readFileSync(`/proc/${pid}/statm`, 'utf8').split(' ')[1]) * 4096) / 1e6;

/** Its browser has nothing in its cache. */
export async function openPage(browser, server, hash = '') {
  const page = await open(browser, 'about:blank', { reducedMotion: 'no-preference' });
  if (server.token) await signIn(page.context(), server.url, server.token);
  await pause(settle_ms);
  await page.goto(server.url + hash);
  return page;
}

/** When the graphics card had drawn the first frame with points, in ms since the page was asked for. */
export const firstPicture = async (page) => (await page.waitForFunction(() => window.headframe?.shown.firstPicture_ms, null, { polling: 100 })).jsonValue();
