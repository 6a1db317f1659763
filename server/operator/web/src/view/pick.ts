// The drawn point nearest to a pixel.

import { Matrix4, Vector3, Vector4 } from 'three';
import { isClipped } from './clip';
import { shared } from './cloud_material';
import type { Clouds } from './clouds';
import type { Frames } from './frames';
import type { Stage } from './stage';

const reach_px = 14;

/** A point of a session's map. It stays where it is when maps move. */
export interface Picked {
  session: number;
  p_session: Vector3;
}

/** In front of others within reach of the pixel; null: nothing is there. */
export function pick(x: number, y: number, stage: Stage, clouds: Clouds, frames: Frames): Picked | null {
  const { camera, size } = stage;
  const view = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  const [roof, low, high] = [shared.roof.value, shared.slice.value.x, shared.slice.value.y];
  const p = new Vector3();
  const clip = new Vector4();
  let found: Picked | null = null;
  let best = Infinity;
  for (const [session, cloud] of clouds.clouds) {
    const T = frames.of(session);
    if (!T) continue;
    for (const [chunk] of cloud.chunks())
      for (let i = 0; i < chunk.count; i++) {
        if (chunk.above_m(i) > roof || chunk.sequence(i) > cloud.lastShown) continue;
        chunk.at(i, p).applyMatrix4(T);
        if (p.z < low || p.z > high || isClipped(p.x, p.y)) continue;
        clip.set(p.x, p.y, p.z, 1).applyMatrix4(view);
        if (clip.w <= 0) continue;
        const dx = ((clip.x / clip.w + 1) / 2) * size.x - x;
        const dy = ((1 - clip.y / clip.w) / 2) * size.y - y;
        const squared = dx * dx + dy * dy;
        if (squared > reach_px * reach_px) continue;
        const cost = squared / (reach_px * reach_px) + clip.z / clip.w; // near the pixel, and near the eye
        if (cost >= best) continue;
        best = cost;
        found = { session, p_session: chunk.at(i, new Vector3()) };
      }
  }
  return found;
}
