// Distance between two points of the clouds that the operator picks.

import { Matrix4, Vector3, Vector4 } from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';
import { shared } from './cloud_material';
import type { Clouds } from './clouds';
import type { Frames } from './frames';
import type { Label } from './labels';
import type { Stage } from './stage';

const reach_px = 14;

/** The drawn point nearest to a pixel of the page: in front of others within reach; none: nothing is there. */
export function pick(x: number, y: number, stage: Stage, clouds: Clouds, frames: Frames): Vector3 | null {
  const { camera, size } = stage;
  const view = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  const [roof, low, high] = [shared.roof.value, shared.slice.value.x, shared.slice.value.y];
  const p = new Vector3();
  const clip = new Vector4();
  let found: Vector3 | null = null;
  let best = Infinity;
  for (const [id, cloud] of clouds.clouds) {
    const T = frames.of(id);
    if (!T) continue;
    for (const [chunk] of cloud.chunks())
      for (let i = 0; i < chunk.count; i++) {
        if (chunk.above_m(i) > roof) continue;
        chunk.at(i, p).applyMatrix4(T);
        if (p.z < low || p.z > high) continue;
        clip.set(p.x, p.y, p.z, 1).applyMatrix4(view);
        if (clip.w <= 0) continue;
        const dx = ((clip.x / clip.w + 1) / 2) * size.x - x;
        const dy = ((1 - clip.y / clip.w) / 2) * size.y - y;
        const squared = dx * dx + dy * dy;
        if (squared > reach_px * reach_px) continue;
        const cost = squared / (reach_px * reach_px) + clip.z / clip.w; // near the pixel, and near the eye
        if (cost >= best) continue;
        best = cost;
        found = p.clone();
      }
  }
  return found;
}

export class Measure {
  readonly ends: Vector3[] = [];
  private readonly line: LineSegments2;

  constructor(private readonly stage: Stage) {
    this.line = new LineSegments2(new LineSegmentsGeometry(), new LineMaterial({ linewidth: 2, depthTest: false, transparent: true }));
    this.line.renderOrder = 30;
    this.line.frustumCulled = false;
    this.line.visible = false;
    stage.scene.add(this.line);
  }

  /** The third point begins anew. */
  take(place: Vector3): void {
    if (this.ends.length === 2) this.ends.length = 0;
    this.ends.push(place);
    this.line.visible = this.ends.length === 2;
    if (this.line.visible) {
      this.line.geometry.dispose();
      this.line.geometry = new LineSegmentsGeometry().setPositions(this.ends.flatMap((end) => end.toArray()));
    }
    this.stage.draw();
  }

  clear(): void {
    this.ends.length = 0;
    this.line.visible = false;
    this.stage.draw();
  }

  paint(colour: string): void {
    this.line.material.color.setStyle(colour, 'srgb-linear');
  }

  /** In words; empty without two ends. */
  get text(): string {
    const [p, q] = this.ends;
    if (!q) return '';
    const flat = Math.hypot(q.x - p.x, q.y - p.y);
    const up = q.z - p.z;
    return `${p.distanceTo(q).toFixed(2)} m · level ${flat.toFixed(2)} m · height ${up < 0 ? '−' : '+'}${Math.abs(up).toFixed(2)} m`;
  }

  labels(): Label[] {
    const dots: Label[] = this.ends.map((place, index) => ({ key: `measure-${index}`, place, text: index === 0 ? 'A' : 'B', kind: 'measure', rank: 0 }));
    if (this.text) dots.push({ key: 'measure-text', place: this.ends[0].clone().lerp(this.ends[1], 0.5), text: this.text, kind: 'measure', rank: 0 });
    return dots;
  }
}
