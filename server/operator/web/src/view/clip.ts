// What of the map is shown: all, or what lies over a rectangle. Heights are cut by the slice. Pure but for the shared uniforms.

import { Vector2 } from 'three';
import { shared } from './cloud_material';

/** A rectangle of a component's frame, from above: its middle, how its length is turned against x, half its length and width; metres. */
export interface Clip {
  component: number;
  x: number;
  y: number;
  yaw_rad: number;
  half_m: [number, number];
}

const least_m = 0.1;

/** With sides along x and y. */
export function boxAround(component: number, p: { x: number; y: number }, q: { x: number; y: number }): Clip {
  const half = (a: number, b: number) => Math.max(Math.abs(a - b) / 2, least_m);
  return { component, x: (p.x + q.x) / 2, y: (p.y + q.y) / 2, yaw_rad: 0, half_m: [half(p.x, q.x), half(p.y, q.y)] };
}

/** Along the line from p to q. */
export function slabAlong(component: number, p: { x: number; y: number }, q: { x: number; y: number }, width_m: number): Clip {
  const [dx, dy] = [q.x - p.x, q.y - p.y];
  return { component, x: (p.x + q.x) / 2, y: (p.y + q.y) / 2, yaw_rad: Math.atan2(dy, dx), half_m: [Math.max(Math.hypot(dx, dy) / 2, least_m), Math.max(width_m / 2, least_m)] };
}

export const clipText = ({ half_m: [x, y] }: Clip) => `${(2 * x).toFixed(1)} × ${(2 * y).toFixed(1)} m`;

/** null: nothing is cut. `offset` is where the view draws the component's origin. */
export function setClip(clip: Clip | null, offset: { x: number; y: number }): void {
  if (!clip) {
    shared.clipHalf.value.set(1e9, 1e9);
    return;
  }
  shared.clip.value.set(clip.x + offset.x, clip.y + offset.y, Math.cos(clip.yaw_rad), Math.sin(clip.yaw_rad));
  shared.clipHalf.value.set(...clip.half_m);
}

/** As the shader decides. */
export function isClipped(x: number, y: number): boolean {
  const { x: cx, y: cy, z: c, w: s } = shared.clip.value;
  const off = new Vector2(x - cx, y - cy);
  return Math.abs(c * off.x + s * off.y) > shared.clipHalf.value.x || Math.abs(-s * off.x + c * off.y) > shared.clipHalf.value.y;
}
