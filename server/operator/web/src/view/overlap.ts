// Where two sessions meet, from their paths alone. Pure.

import { Vector3 } from 'three';
import type { Keyframe, Transform } from '../station/types';
import { matrixOf } from './layout';

const near_m = 5; // in one drift: two that run side by side lie further apart
const mostLinks = 14;

export interface Link {
  p_a: Vector3; // in a's frame
  p_b: Vector3; // in b's frame
  a: number; // the keyframe's
  b: number;
}

/** Keyframes of b that T_a_b lays near one of a, each with that one; the middle one is links[length >> 1]. */
export function overlapLinks(a: Keyframe[], b: Keyframe[], T_a_b: Transform): Link[] {
  const T = matrixOf(T_a_b);
  const links: Link[] = [];
  const p = new Vector3();
  for (const { position, sequence } of b) {
    p.fromArray(position).applyMatrix4(T);
    let nearest: Keyframe | null = null;
    let least = near_m * near_m;
    for (const other of a) {
      const [x, y, z] = other.position;
      const squared = (x - p.x) ** 2 + (y - p.y) ** 2 + (z - p.z) ** 2;
      if (squared < least) {
        least = squared;
        nearest = other;
      }
    }
    if (nearest) links.push({ p_a: new Vector3(...nearest.position), p_b: new Vector3(...position), a: nearest.sequence, b: sequence });
  }
  const every = Math.max(1, Math.ceil(links.length / mostLinks));
  return links.filter((_, index) => index % every === 0);
}
