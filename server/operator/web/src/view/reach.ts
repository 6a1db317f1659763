// How far points reach to all sides, seen from above: so that a frame lies around them however their map is turned.

import { Vector3 } from 'three';

const sides = 16;
const turn = (2 * Math.PI) / sides;
const directions = Array.from({ length: sides }, (_, at) => ({ x: Math.cos(at * turn), y: Math.sin(at * turn) }));
const steps = 2; // metres: what reaches a little further changes nothing

export class Reach {
  private readonly far = new Float64Array(sides).fill(-Infinity);
  /** Counts the times that it grew. */
  version = 0;

  take(x: number, y: number): void {
    for (let at = 0; at < sides; at++) {
      const far = directions[at].x * x + directions[at].y * y;
      if (far <= this.far[at]) continue;
      this.far[at] = Math.ceil(far / steps) * steps;
      this.version++;
    }
  }

  /** A polygon around all that was taken, a few metres wider at the most; none when nothing was. */
  corners(): Vector3[] {
    if (this.version === 0) return [];
    return directions.map((one, at) => {
      const next = directions[(at + 1) % sides];
      const [far, further] = [this.far[at], this.far[(at + 1) % sides]];
      return new Vector3(far * next.y - further * one.y, further * one.x - far * next.x, 0).divideScalar(Math.sin(turn));
    });
  }
}
