// What the page says of pairs, points and places, by itself.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './module.mjs';

const { lookOf, RobotColours } = await load('view/palette');
const { doubtOf, sureness, wantsLook } = await load('station/pairs');
const { pointsOf, rowsOf, transformOf } = await load('actions/survey_text');
const { quoted, robotAddress } = await load('actions/invitation');
const { areaOf, lengthOf } = await load('view/figures');
const { gridLines, roundStep } = await load('view/grid');
const { Log } = await load('station/log');
const { bend } = await load('panels/graph_layout');

const pair = (state, decision = 'none', probability = 0.999) => ({ state, decision, evidence: { probability } });

test('a pair that others contradict is held back, wants a look, and is not called sure', () => {
  assert.equal(lookOf(pair('verified')).word, 'held back');
  assert.ok(wantsLook(pair('verified')));
  assert.match(sureness(pair('verified')), /by the pair alone/);
  assert.match(doubtOf(pair('verified')), /look-alike/);
});

test('what an operator refused is refused, and is no match that is surely right', () => {
  assert.equal(lookOf(pair('rejected', 'refused')).word, 'refused');
  assert.doesNotMatch(sureness(pair('rejected', 'refused')), /sure/);
  assert.ok(!wantsLook(pair('rejected', 'refused')));
});

test('a merge that was withdrawn is another thing than one that an operator took apart', () => {
  assert.equal(lookOf(pair('retracted')).word, 'withdrawn');
  assert.equal(lookOf(pair('retracted', 'retracted')).word, 'taken apart');
});

test('an improbable pair is not confirmed without a word, a probable or merged one is', () => {
  assert.match(doubtOf(pair('candidate', 'none', 0.001)), /probability/);
  assert.equal(doubtOf(pair('candidate', 'none', 0.9)), '');
  assert.equal(doubtOf(pair('published', 'none', 0.001)), '');
});

test('a provisional pair waits for path, wants no look, and is not confirmed without a word', () => {
  assert.equal(lookOf(pair('provisional')).word, 'provisional');
  assert.ok(!wantsLook(pair('provisional')));
  assert.match(sureness(pair('provisional')), /sure/);
  assert.match(doubtOf({ ...pair('provisional'), evidence: { probability: 0.99, awaited_m: 22.4 } }), /23 m of path/);
});

test('a convincing pair that waits for path says so, and for how many metres; an unconvincing one is unsure', () => {
  const waiting = (state, probability, awaited_m, decision = 'none') => ({ state, decision, evidence: { probability, awaited_m } });
  assert.equal(lookOf(waiting('candidate', 0.97, 22.4)).word, 'waits for 23 m of path');
  assert.equal(lookOf(waiting('provisional', 0.9, 5)).word, 'waits for 5 m of path');
  assert.ok(!wantsLook(waiting('candidate', 0.97, 22.4)));
  for (const unsure of [waiting('candidate', 0.89, 22.4), waiting('candidate', 0.97, 0), waiting('candidate', 0.97, null)]) {
    assert.equal(lookOf(unsure).word, 'unsure');
    assert.ok(wantsLook(unsure));
  }
  assert.equal(lookOf(waiting('candidate', 0.97, 22.4, 'refused')).word, 'refused');
  assert.equal(lookOf(waiting('published', 0.97, 22.4)).word, 'merged');
});

test('sessions of one robot are told apart, and robots more so', () => {
  const colours = new RobotColours();
  const name = (robot, session) => ({ robot, session });
  const shown = ['1', '2', '3', '4'].map((session) => colours.of(name('a', session), true));
  assert.equal(new Set(shown).size, 4);
  assert.equal(colours.of(name('a', '1'), true), shown[0], 'the same again');
  assert.ok(!shown.includes(colours.of(name('b', '1'), true)));
});

test('control points come with or without titles, between commas, semicolons, tabs or blanks', () => {
  const row = { name: 'S1', session: ['1', '2.5', '3'], grid: ['100', '200', '-3'] };
  for (const text of ['S1,1,2.5,3,100,200,-3', 'name;x;y;z;e;n;h\nS1;1;2,5;3;100;200;-3\n', 'S1\t1\t2,5\t3\t100\t200\t-3', '# made today\n\nS1 1 2.5 3   100 200 -3\r\n', 'Name, X, Y, Z, East, North, Height\nS1, 1, 2.5, 3, 100, 200, -3'])
    assert.deepEqual(rowsOf(text), [row], text);
});

test('a line that is wrong is named with what is wrong', () => {
  assert.throws(() => rowsOf('S1 1 2 3 4 5 6\nS2 1 2 3 4 5'), /Line 2: .*5 cells/);
  assert.throws(() => rowsOf('S1 1 2 3 4 5 6\nS2 1 2 3 4 5 six'), /Line 2: “six” is no number/);
  assert.throws(() => pointsOf(rowsOf('S1 1 2 3 4 5 6\nS2 1 2 3 4 5 6')), /Three control points are needed; there are 2/);
  assert.throws(() => pointsOf([{ name: 'P1', session: ['1', '2', '3'], grid: ['', '', ''] }]), /P1: east is missing/);
  assert.equal(transformOf('1 0 0 5  0 1 0 6  0 0 1 7  0 0 0 1').length, 16);
  assert.equal(transformOf('1 2 3'), null);
});

test('a robot is told where to come as the operator came, when the server listens everywhere', () => {
  assert.equal(robotAddress('0.0.0.0:7447', 'mine.local'), 'mine.local:7447');
  assert.equal(robotAddress('127.0.0.1:7000', 'mine.local'), '127.0.0.1:7000');
  assert.equal(robotAddress(null, 'mine.local'), 'mine.local:7447');
  assert.equal(quoted('r1'), 'r1');
  assert.equal(quoted("o'neill 2"), `'o'\\''neill 2'`);
});

test('lengths and areas are those of the points', () => {
  const square = [[0, 0], [3, 0], [3, 4], [0, 4]].map(([x, y]) => ({ x, y, z: 2 }));
  assert.equal(lengthOf(square), 10);
  assert.equal(areaOf(square), 12);
  assert.equal(areaOf([...square].reverse()), 12);
});

test('lines of coordinates lie where the grid says, whichever way the map is turned', () => {
  assert.deepEqual([149, 150, 0.7, 99].map(roundStep), [100, 100, 0.5, 50]);
  const yaw = 0.4;
  const T = [Math.cos(yaw), -Math.sin(yaw), 0, 1000, Math.sin(yaw), Math.cos(yaw), 0, 2000, 0, 0, 1, 0, 0, 0, 0, 1];
  const box = { min: { x: -50, y: -20 }, max: { x: 70, y: 90 } };
  const lines = gridLines(box, T, 20);
  assert.ok(lines.length > 8);
  for (const { axis, value, from, to } of lines)
    for (const [x, y] of [from, to]) {
      assert.ok(Math.abs(T[4 * axis] * x + T[4 * axis + 1] * y + T[4 * axis + 3] - value) < 1e-6 && value % 20 === 0);
      assert.ok(x >= box.min.x - 1e-9 && x <= box.max.x + 1e-9 && y >= box.min.y - 1e-9 && y <= box.max.y + 1e-9);
    }
});

test('a line of the merge graph keeps clear of other nodes', () => {
  const [p, q, between] = [{ x: 0, y: 0 }, { x: 100, y: 0 }, { x: 50, y: 0 }];
  assert.deepEqual(bend(p, q, [], 15), { x: 50, y: 0 });
  const middle = bend(p, q, [between], 15);
  assert.ok(Math.hypot(middle.x - between.x, middle.y - between.y) >= 15);
});

test('a withdrawn merge is an alarm until it was seen, also after a reload, or is merged again', () => {
  const kept = new Map();
  globalThis.localStorage = { getItem: (key) => kept.get(key) ?? null, setItem: (key, value) => void kept.set(key, value) };
  const entry = (id, kind) => ({ id, at_s: 1000 + id, kind, text: kind, session_id: null, alignment_id: 7 });
  const log = new Log();
  log.take([entry(1, 'merged'), entry(2, 'withdrawn')]);
  assert.equal(log.alarms.length, 1);
  assert.equal(log.entries[0].tone, 'bad');
  log.take([entry(2, 'withdrawn')]);
  assert.equal(log.entries.length, 2, 'an entry that came twice is one');
  const again = new Log();
  again.take([entry(1, 'merged'), entry(2, 'withdrawn'), entry(3, 'merged')]);
  assert.equal(again.alarms.length, 0);
  log.seen();
  const later = new Log();
  later.take([entry(2, 'withdrawn')]);
  assert.equal(later.alarms.length, 0);
  later.take([entry(4, 'withdrawn')]);
  assert.equal(later.alarms.length, 1);
});
