// A path that came thinned has a stand-in for each keyframe that was left out, evenly between those that stayed.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './module.mjs';

const { filled } = await load('station/thin');

const keyframe = (sequence, stamp_s, position, quaternion = [0, 0, 0, 1]) => ({ sequence, stamp_s, position, quaternion });

test('numbers have no holes afterwards, and what was there stays', () => {
  const kept = [keyframe(3, 10, [0, 0, 0]), keyframe(4, 11, [1, 0, 0]), keyframe(8, 31, [1, 8, -4])];
  const path = filled(kept);
  assert.deepEqual(path.map(({ sequence }) => sequence), [3, 4, 5, 6, 7, 8]);
  for (const one of kept) assert.ok(path.includes(one));
  assert.deepEqual(path[3].position, [1, 4, -2]);
  assert.equal(path[3].stamp_s, 21);
  assert.deepEqual(filled([]), []);
  assert.deepEqual(filled(kept.slice(0, 1)), kept.slice(0, 1));
});

test('a stand-in is turned half way between its neighbours, whichever sign their quaternions have', () => {
  const half = Math.SQRT1_2;
  for (const sign of [1, -1]) {
    const [, middle] = filled([keyframe(1, 0, [0, 0, 0]), keyframe(3, 2, [2, 0, 0], [0, 0, sign * half, sign * half])]);
    const yaw_deg = (2 * Math.atan2(middle.quaternion[2], middle.quaternion[3]) * 180) / Math.PI;
    assert.ok(Math.abs(yaw_deg - 45) < 1e-6);
    assert.ok(Math.abs(Math.hypot(...middle.quaternion) - 1) < 1e-9);
  }
});
