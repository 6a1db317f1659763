// Sections and clips, by themselves.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './module.mjs';

const { Profile, profileCsv, profileScale } = await load('view/profile');
const { boxAround, isClipped, setClip, slabAlong } = await load('view/clip');

const random = (seed) => () => (seed = (seed * 48271) % 2147483647) / 2147483647;

/** Distance of a point from a leg, and how far along it lies, by the definition: the nearest of many places on it. */
function slowly(p, from, to) {
  const [length, steps] = [Math.hypot(to.x - from.x, to.y - from.y), 4000];
  let best = { off: Infinity, along: 0 };
  for (let at = 0; at <= steps; at++) {
    const share = at / steps;
    const off = Math.hypot(p.x - from.x - share * (to.x - from.x), p.y - from.y - share * (to.y - from.y));
    if (off < best.off) best = { off, along: share * length };
  }
  return best;
}

test('a profile has the points near its line, at the place where they are nearest to it', () => {
  const next = random(11);
  for (let round = 0; round < 20; round++) {
    const place = () => ({ x: 40 * next() - 20, y: 40 * next() - 20 });
    const [from, to, width_m] = [place(), place(), 1 + 6 * next()];
    for (let at = 0; at < 20; at++) {
      const p = { ...place(), z: next() };
      const profile = new Profile([from, to], width_m);
      profile.take(p.x, p.y, p.z, p.z - 100, 7);
      const { off, along } = slowly(p, from, to);
      const inside = along > 0.02 && along < profile.length_m - 0.02;
      if (!inside || Math.abs(off - width_m / 2) < 0.02) continue; // the ends and the edges belong to nobody here
      assert.equal(profile.points.length, off < width_m / 2 ? 1 : 0);
      if (profile.points.length) assert.ok(Math.abs(profile.points[0].along_m - along) < 0.02);
    }
  }
});

test('a line with corners counts on from leg to leg', () => {
  const profile = new Profile([{ x: 0, y: 0 }, { x: 10, y: 0 }, { x: 10, y: 0 }, { x: 10, y: 5 }], 2);
  assert.equal(profile.length_m, 15);
  profile.take(10.5, 3, 1, 1, 1);
  assert.equal(profile.points[0].along_m, 13);
  assert.deepEqual(profile.points[0].place, [10.5, 3, 1]);
  assert.equal(new Profile([{ x: 0, y: 0 }], 2).length_m, 0);
});

test('of too many points an even sample stays', () => {
  const profile = new Profile([{ x: 0, y: 0 }, { x: 1000, y: 0 }], 2);
  const most = 1_000_000;
  for (let at = 0; at < most; at++) profile.take((1000 * at) / most, 0, 0, 0, 1);
  assert.ok(profile.points.length > 60_000 && profile.points.length < 200_000, `${profile.points.length}`);
  const first = profile.points.filter(({ along_m }) => along_m < 500).length / profile.points.length;
  assert.ok(Math.abs(first - 0.5) < 0.05, `${first} of them lie in the first half`);
});

test('heights are drawn as they are where there is room, and at a round multiple elsewhere', () => {
  assert.deepEqual(profileScale(10, 10, 500, 100), { along_px: 10, times: 1 });
  assert.deepEqual(profileScale(100, 5, 500, 124), { along_px: 5, times: 2 });
  assert.deepEqual(profileScale(100, 5, 500, 125), { along_px: 5, times: 5 });
  assert.deepEqual(profileScale(0, 0, 500, 100).times, 1);
});

test('a profile as lines: titles, millimetres, names in quotes where they need it, the grid where it is known', () => {
  const points = [{ along_m: 1.23456, height_m: -2, session: 3, place: [1, 2, 3] }];
  assert.equal(profileCsv(points, () => 'Drift 7, "east"', null), 'along_m,height_m,session,x_m,y_m,z_m\n1.235,-2.000,"Drift 7, ""east""",1.000,2.000,3.000\n');
  assert.match(profileCsv(points, () => 'a', ([x, y, z]) => [x + 1000, y, z]), /grid_height_m\n.*,a,1\.000,2\.000,3\.000,1001\.000,2\.000,3\.000\n$/);
});

test('a clip keeps what lies over its rectangle, however it is turned; none keeps all', () => {
  const next = random(5);
  setClip(null, { x: 0, y: 0 });
  assert.ok(!isClipped(1e6, -1e6));
  setClip(boxAround(1, { x: 3, y: 9 }, { x: -1, y: 5 }), { x: 100, y: 0 });
  for (const [x, y, cut] of [[101, 7, false], [102.9, 8.9, false], [103.1, 7, true], [101, 9.1, true], [1, 7, true]]) assert.equal(isClipped(x, y), cut, `${x} ${y}`);
  for (let round = 0; round < 500; round++) {
    const [yaw, width_m, length_m] = [6.28 * next(), 1 + 4 * next(), 5 + 20 * next()];
    const along = { x: Math.cos(yaw), y: Math.sin(yaw) };
    setClip(slabAlong(1, { x: 2, y: 3 }, { x: 2 + length_m * along.x, y: 3 + length_m * along.y }, width_m), { x: 0, y: 0 });
    const [far, off] = [(1.4 * next() - 0.2) * length_m, (1.4 * next() - 0.7) * width_m];
    const inside = far > 0 && far < length_m && Math.abs(off) < width_m / 2;
    assert.equal(isClipped(2 + far * along.x - off * along.y, 3 + far * along.y + off * along.x), !inside);
  }
  setClip(null, { x: 0, y: 0 });
});
