// The points that a frame may have, against graphics cards that take so long for each.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './module.mjs';

const { moving, Pace } = await load('view/pace');
const [least, most] = [200_000, 3_000_000];

/** Frames of a map of ten million points, each as long as the card takes for it. */
function framesOn(millisecondsOf, count = 60) {
  const pace = new Pace(moving, least, most);
  return Array.from({ length: count }, () => {
    const drawn = Math.min(pace.points, 10_000_000);
    const frame_ms = millisecondsOf(drawn);
    pace.took(frame_ms, drawn);
    return { drawn, frame_ms };
  });
}

test('never more than the budget nor less than the least, however long frames take', () => {
  for (const cost of [0, 1e-5, 1e-4, 1e-3, 1]) for (const { drawn } of framesOn((points) => cost * points)) assert.ok(drawn <= most && drawn >= least);
});

test('a swift card draws all that the budget allows', () => assert.equal(framesOn(() => 8).at(-1).drawn, most));

test('a slow card draws as much as it can in time, after a few frames', () => {
  const frames = framesOn((points) => 5 + 1e-4 * points); // 305 ms for the whole budget
  assert.ok(frames[0].frame_ms > 300);
  for (const { frame_ms, drawn } of frames.slice(4)) assert.ok(frame_ms <= moving.late_ms && drawn > least, `${drawn} points took ${frame_ms} ms`);
});

test('a card that was busy with something else comes back to the budget', () => {
  let at = 0;
  const frames = framesOn(() => (at++ < 5 ? 400 : 10));
  assert.ok(frames[5].drawn < most);
  assert.equal(frames.at(-1).drawn, most);
});
