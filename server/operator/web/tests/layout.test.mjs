// Where maps lie: the frame of one holds all of its points, whichever way it is turned.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Box2, Box3, Matrix4, Vector2, Vector3 } from 'three';
import { load } from './module.mjs';

const { Reach } = await load('view/reach');
const { extentOf, layOut } = await load('view/layout');

/** A drift of so many metres, and some side drifts: no circle, no rectangle. */
function driftPoints() {
  const points = [];
  for (let at = 0; at < 400; at++) points.push(new Vector3(0.5 * at, 3 * Math.sin(0.1 * at), 1));
  for (let at = 0; at < 80; at++) points.push(new Vector3(120 + 0.1 * at, -0.9 * at, 2));
  return points;
}

test('a reach holds every point at every turn, and little more', () => {
  const points = driftPoints();
  const reach = new Reach();
  for (const { x, y } of points) reach.take(x, y);
  for (let turn = 0; turn < 6.3; turn += 0.37) {
    const T = new Matrix4().makeRotationZ(turn).setPosition(40, -900, 3);
    const around = new Box3().setFromPoints(reach.corners().map((corner) => new Vector3(corner.x, corner.y, 0).applyMatrix4(T)));
    const exact = new Box3().setFromPoints(points.map((point) => point.clone().applyMatrix4(T)));
    for (const axis of ['x', 'y']) {
      assert.ok(around.min[axis] <= exact.min[axis] + 1e-9 && around.max[axis] >= exact.max[axis] - 1e-9, `turned by ${turn}`);
      assert.ok(around.max[axis] - around.min[axis] < 1.1 * (exact.max[axis] - exact.min[axis]) + 8, `turned by ${turn}`);
    }
  }
});

test('a reach counts when it grows, and has no corners before the first point', () => {
  const reach = new Reach();
  assert.deepEqual(reach.corners(), []);
  for (const x of [8, 10]) reach.take(x, 0);
  const { version } = reach;
  reach.take(9, 0);
  assert.equal(reach.version, version, 'between two others');
  reach.take(50, 0);
  assert.ok(reach.version > version);
});

test('the plot of a map that is seen far into a side drift holds it, and plots do not overlap', () => {
  const path = new Box3(new Vector3(0, 0, 0), new Vector3(60, 10, 0));
  const points = new Box3(new Vector3(-3, -95, 0), new Vector3(64, 14, 0));
  const plots = layOut([extentOf(1, [{ path, points }]), extentOf(2, [{ path, points: new Box3() }]), extentOf(3, [{ path: new Box3(), points: new Box3() }])]);
  const inside = new Box2(new Vector2(points.min.x, points.min.y), new Vector2(points.max.x, points.max.y));
  assert.ok(new Box2(plots.get(1).box.min, plots.get(1).box.max).containsBox(inside.translate(plots.get(1).offset)));
  const boxes = [...plots.values()].map(({ box }) => new Box2(box.min, box.max));
  for (const [at, box] of boxes.entries()) for (const other of boxes.slice(at + 1)) assert.ok(!box.intersectsBox(other));
});

test('maps that are not merged fill a picture, and do not lie in one row', () => {
  const box = () => ({ path: new Box3(new Vector3(0, 0, 0), new Vector3(100, 100, 0)), points: new Box3() });
  for (const count of [4, 6, 9, 12]) {
    const plots = [...layOut(Array.from({ length: count }, (_, at) => extentOf(at + 1, [box()]))).values()];
    const all = plots.reduce((sum, plot) => sum.union(new Box2(plot.box.min, plot.box.max)), new Box2()).getSize(new Vector2());
    assert.ok(all.x < 3 * all.y, `${count} maps span ${all.x} by ${all.y} m`);
    for (const [at, { box: one }] of plots.entries()) for (const { box: other } of plots.slice(at + 1)) assert.ok(!new Box2(one.min, one.max).intersectsBox(new Box2(other.min, other.max)));
  }
});
