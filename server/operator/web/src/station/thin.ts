// Paths come thinned at first: what was left out lies near the straight line between what stayed, evenly by its number
// (README of server/operator). Pure.

import type { Keyframe } from './types';

/** With a stand-in for each keyframe that was left out, so that counts and numbers are those of the whole path. */
export function filled(kept: Keyframe[]): Keyframe[] {
  const out: Keyframe[] = [];
  for (const [at, keyframe] of kept.entries()) {
    const before = kept[at - 1];
    if (before) for (let sequence = before.sequence + 1; sequence < keyframe.sequence; sequence++) out.push(between(before, keyframe, sequence));
    out.push(keyframe);
  }
  return out;
}

function between(from: Keyframe, to: Keyframe, sequence: number): Keyframe {
  const share = (sequence - from.sequence) / (to.sequence - from.sequence);
  const mixed = (a: number, b: number) => a + share * (b - a);
  const [x, y, z] = from.position.map((value, axis) => mixed(value, to.position[axis]));
  const side = Math.sign(from.quaternion.reduce((sum, value, axis) => sum + value * to.quaternion[axis], 0)) || 1; // q and -q turn alike
  const turned = from.quaternion.map((value, axis) => mixed(value, side * to.quaternion[axis]));
  const [qx, qy, qz, qw] = turned.map((value) => value / Math.hypot(...turned));
  return { sequence, stamp_s: mixed(from.stamp_s, to.stamp_s), position: [x, y, z], quaternion: [qx, qy, qz, qw] };
}
