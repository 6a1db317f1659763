// One map laid on another by hand: where it lies and how it is turned. Pure.

import { Matrix4, Vector3 } from 'three';

const near_m = 10; // places that are nearer are of one tunnel, as far as heights and neighbours go
const mostPlaces = 200; // of a path that are compared

/** The map `component` on the map `on`: its pivot lies at `at`, and it is turned about that. */
export interface Laid {
  readonly on: number;
  readonly component: number;
  readonly pivot: Vector3; // in the frame of `component`
  readonly at: Vector3; // in the frame of `on`
  readonly turn_rad: number;
}

/** T_on_component */
export const placementOf = ({ pivot, at, turn_rad }: Laid): Matrix4 =>
  new Matrix4().makeTranslation(at).multiply(new Matrix4().makeRotationZ(turn_rad)).multiply(new Matrix4().makeTranslation(pivot.clone().negate()));

/** Session b's origin in session a, and how b is turned (degrees), from where both lie on the same map: what the server is asked. */
export function originOf(T_on_a: Matrix4, T_on_b: Matrix4): [number, number, number, number] {
  const { elements } = T_on_a.clone().invert().multiply(T_on_b);
  return [elements[12], elements[13], elements[14], (Math.atan2(elements[1], elements[0]) * 180) / Math.PI];
}

/** The first and the last, and those between them evenly, as many as are worth comparing. */
export function thinned<T>(path: readonly T[]): T[] {
  const most = Math.min(path.length, mostPlaces);
  return Array.from({ length: most }, (_, at) => path[most < 2 ? 0 : Math.round((at * (path.length - 1)) / (most - 1))]);
}

/** The middle of a path from above, at its middle height. */
export function pivotOf(path: readonly Vector3[]): Vector3 {
  const middle = path.reduce((sum, place) => sum.add(place), new Vector3()).divideScalar(Math.max(path.length, 1));
  return middle.setZ(median(path.map(({ z }) => z)) ?? 0);
}

/** By how much b's path has to rise to run as high as a's where both run, in the middle; null: they meet nowhere. */
export function riseOf(a: readonly Vector3[], b: readonly Vector3[]): number | null {
  const rises: number[] = [];
  for (const q of b) {
    let best = near_m;
    let rise: number | null = null;
    for (const p of a) {
      const away = Math.hypot(p.x - q.x, p.y - q.y);
      if (away < best) [best, rise] = [away, p.z - q.z];
    }
    if (rise !== null) rises.push(rise);
  }
  return median(rises);
}

/** Which of the paths most of b runs beside; the one that comes nearest when none does. null: there is none. */
export function besideOf(paths: ReadonlyMap<number, readonly Vector3[]>, b: readonly Vector3[]): number | null {
  let best: { id: number; beside: number; nearest_m: number } | null = null;
  for (const [id, path] of paths) {
    const away = b.map((q) => path.reduce((least, p) => Math.min(least, p.distanceTo(q)), Infinity));
    const found = { id, beside: away.filter((metres) => metres < near_m).length, nearest_m: Math.min(...away) };
    if (!best || found.beside > best.beside || (found.beside === best.beside && found.nearest_m < best.nearest_m)) best = found;
  }
  return best?.id ?? null;
}

function median(values: number[]): number | null {
  return values.length ? values.sort((x, y) => x - y)[values.length >> 1] : null;
}
