// A map that is laid on another: where it is drawn and what the server is told are one placement.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Matrix4, Vector3 } from 'three';
import { load } from './module.mjs';

const { besideOf, originOf, pivotOf, placementOf, riseOf, thinned } = await load('view/laid');

const vector = (x, y, z = 0) => new Vector3(x, y, z);
const tunnel = (from, to, count) => Array.from({ length: count }, (_, at) => vector(...[0, 1, 2].map((axis) => from[axis] + ((to[axis] - from[axis]) * at) / (count - 1))));

test('the pivot lies where it was put, whatever the turn, and turning keeps lengths', () => {
  for (let turn_rad = -7; turn_rad < 7; turn_rad += 0.71) {
    const laid = { on: 1, component: 2, pivot: vector(40, -3, 2), at: vector(-700, 1e5, -60), turn_rad };
    const T = placementOf(laid);
    assert.ok(laid.pivot.clone().applyMatrix4(T).distanceTo(laid.at) < 1e-6);
    const p = vector(43, 1, 2).applyMatrix4(T);
    assert.ok(Math.abs(p.distanceTo(laid.at) - 5) < 1e-6);
    assert.ok(Math.abs(p.z - laid.at.z) < 1e-9, 'it stays level');
  }
});

test("what the server is told is the second session's origin in the first one, and its turn", () => {
  const T_on_a = new Matrix4().makeRotationZ(2.5).setPosition(10, 20, 3);
  for (const yaw_deg of [-179, -90, 0, 12.5, 90, 180]) {
    const T_a_b = new Matrix4().makeRotationZ((yaw_deg * Math.PI) / 180).setPosition(-4, 7, 1.5);
    const told = originOf(T_on_a, T_on_a.clone().multiply(T_a_b));
    for (const [at, value] of [-4, 7, 1.5].entries()) assert.ok(Math.abs(told[at] - value) < 1e-9);
    assert.ok(Math.abs(((told[3] - yaw_deg + 540) % 360) - 180) < 1e-9, `${told[3]} for ${yaw_deg}`);
  }
});

test('a path rises to the one under it where both run, and nowhere else', () => {
  const ramp = tunnel([0, 0, 0], [100, 0, -10], 101);
  const above = tunnel([50, 2, 40], [90, 2, 36], 41); // along the ramp, 45 m over it
  assert.ok(Math.abs(riseOf(ramp, above) + 45) < 0.2);
  assert.equal(riseOf(ramp, tunnel([50, 40, 0], [90, 40, 0], 41)), null, 'they are 40 m apart');
  assert.equal(riseOf(ramp, []), null);
});

test('of several sessions the one is asked that most of the path runs beside', () => {
  const paths = new Map([
    [1, tunnel([0, 0, 0], [30, 0, 0], 31)],
    [2, tunnel([0, 8, 0], [100, 8, 0], 101)],
    [3, tunnel([0, 0, 50], [100, 0, 50], 101)],
    [4, []],
  ]);
  assert.equal(besideOf(paths, tunnel([0, 0, 0], [100, 0, 0], 101)), 2);
  assert.equal(besideOf(paths, tunnel([0, -4, 0], [20, -4, 0], 21)), 1);
  assert.equal(besideOf(paths, tunnel([0, 300, 0], [20, 300, 0], 21)), 2, 'beside none: the nearest');
  assert.equal(besideOf(new Map(), tunnel([0, 0, 0], [1, 0, 0], 2)), null);
});

test('a path is thinned to few places, its ends among them, and an empty one has a pivot too', () => {
  const long = tunnel([0, 0, 0], [1000, 0, 7], 5000);
  const few = thinned(long);
  assert.ok(few.length <= 200 && few[0] === long[0] && few.at(-1) === long.at(-1));
  for (const count of [0, 1, 2, 200]) assert.equal(thinned(long.slice(0, count)).length, count);
  assert.deepEqual(pivotOf([]).toArray(), [0, 0, 0]);
});
