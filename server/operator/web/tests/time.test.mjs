// The axis of time, and ages, by themselves.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './module.mjs';

const { TimeAxis, countUntil } = await load('time/axis');
const { agesOf, sharesOf } = await load('time/ages');
const { momentOf, saidSince } = await load('time/moment');

// A small generator, so that every run draws the same.
const random = (seed) => () => (seed = (seed * 48271) % 2147483647) / 2147483647;

test('drives keep their length on the axis, long pauses become short, and both ways are inverse', () => {
  const day_s = 86400;
  const axis = new TimeAxis([{ from_s: 5000 + day_s, to_s: 5100 + day_s }, { from_s: 1000, to_s: 1100 }, { from_s: 1050, to_s: 1150 }]);
  assert.equal(axis.length_s, 150 + 5 + 100, 'a pause takes a fiftieth of what was driven');
  assert.equal(axis.toStamp(0), 1000);
  assert.equal(axis.toStamp(150), 1150);
  assert.equal(axis.toStamp(155), 5000 + day_s);
  assert.equal(axis.toStamp(255), 5100 + day_s);
  assert.equal(axis.toAxis(1150 + (5000 + day_s - 1150) / 5), 151);
  assert.equal(axis.toAxis(0), 0);
  assert.equal(axis.toAxis(1e9), 255);
});

test('whatever was driven, later is further along, and there and back is the same', () => {
  const next = random(7);
  for (let round = 0; round < 200; round++) {
    const spans = Array.from({ length: 1 + Math.floor(5 * next()) }, () => {
      const from_s = 1e4 * next();
      return { from_s, to_s: from_s + 500 * next() };
    });
    const axis = new TimeAxis(spans);
    let before_s = -Infinity;
    for (let step = 0; step <= 50; step++) {
      const at_s = (step / 50) * axis.length_s;
      const stamp_s = axis.toStamp(at_s);
      assert.ok(stamp_s >= before_s, 'monotonic');
      assert.ok(Math.abs(axis.toAxis(stamp_s) - at_s) < 1e-6, `${at_s} became ${axis.toAxis(stamp_s)}`);
      before_s = stamp_s;
    }
    for (const { from_s, to_s } of spans) assert.ok(Math.abs(axis.toStamp(axis.toAxis(from_s)) - from_s) < 1e-6 && axis.toAxis(to_s) <= axis.length_s + 1e-9);
  }
});

test('without drives there is no time, and one moment is a whole axis', () => {
  assert.equal(new TimeAxis([]).length_s, 0);
  const moment = new TimeAxis([{ from_s: 3, to_s: 3 }]);
  assert.deepEqual([moment.length_s, moment.toStamp(0), moment.toAxis(9)], [0, 3, 0]);
});

test('keyframes are counted up to a moment, with the one of that moment', () => {
  const path = [1, 2, 2, 5].map((stamp_s) => ({ stamp_s }));
  for (const [stamp_s, count] of [[0.9, 0], [1, 1], [2, 3], [4.99, 3], [5, 4], [Infinity, 4]]) assert.equal(countUntil(path, stamp_s), count);
});

test('ages are shares of all the time that dated sessions span', () => {
  const path = (from_s, to_s, first = 1) => [{ sequence: first, stamp_s: from_s }, { sequence: first + 10, stamp_s: to_s }];
  const [undated, old, recent] = [path(0, 100), path(1.5e9, 1.5e9 + 10), path(1.5e9 + 90, 1.5e9 + 100, 5)];
  const ages = agesOf([undated, old, recent, []]);
  assert.deepEqual(ages, { oldest_s: 1.5e9, newest_s: 1.5e9 + 100 });
  const share = (of, sequence) => sharesOf(of, ages)[0] + sharesOf(of, ages)[1] * sequence;
  for (const [of, sequence, expected] of [[old, 1, 0], [old, 11, 0.1], [recent, 5, 0.9], [recent, 15, 1]]) assert.ok(Math.abs(share(of, sequence) - expected) < 1e-9);
  assert.ok(share(undated, 1) < 0, 'older than all that have a date');
  assert.deepEqual(agesOf([undated]), { oldest_s: 0, newest_s: 100 });
});

test('between two keyframes a robot is part of the way, and after the last where it says that it is', () => {
  const path = [1, 2, 4].map((stamp_s, at) => ({ sequence: at + 1, stamp_s }));
  assert.deepEqual(momentOf(path, 0.5), [0, 0]);
  assert.deepEqual(momentOf(path, 3), [2, 0.5]);
  assert.deepEqual(momentOf(path, 9), [3, 0]);
  const says = (stamp_s, connected = true) => ({ connected, live: { stamp_s, T_session_sensor: [stamp_s] } });
  assert.deepEqual(saidSince(path, says(5)), [5]);
  assert.deepEqual(saidSince(path, says(4)), [4]);
  assert.equal(saidSince(path, says(3.9)), null, 'its last keyframe is newer');
  assert.equal(saidSince(path, says(5, false)), null, 'it has left');
  assert.equal(saidSince([], says(5)), null);
  assert.equal(saidSince(path, { connected: true, live: null }), null);
  assert.equal(saidSince(path, undefined), null);
});
