// Some thousand points that are drawn with one call, in random order: any first part of them is an even sample.

import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Points, type ShaderMaterial, Sphere, Vector3 } from 'three';
import type { Reach } from './reach';

const fullPoints = 16384;
const firstPoints = 4096; // of a cloud that begins: whatever there is room for goes to the graphics card
const unit_m = 0.005;
const headBytes = 20;
const pointBytes = 6;

export class Chunk {
  readonly points: Points;
  count = 0;
  private readonly most: number;
  private readonly position: Float32Array;
  private readonly seen: Float32Array;
  private readonly low = new Vector3(Infinity, Infinity, Infinity);
  private readonly high = new Vector3(-Infinity, -Infinity, -Infinity);

  constructor(material: ShaderMaterial, first: boolean) {
    this.most = first ? firstPoints : fullPoints;
    this.position = new Float32Array(3 * this.most);
    this.seen = new Float32Array(2 * this.most);
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(this.position, 3).setUsage(DynamicDrawUsage));
    geometry.setAttribute('seen', new BufferAttribute(this.seen, 2).setUsage(DynamicDrawUsage));
    geometry.boundingSphere = new Sphere();
    this.points = new Points(geometry, material);
    this.points.matrixAutoUpdate = false;
  }

  get isFull(): boolean {
    return this.count === this.most;
  }

  /** The new point takes the place of a random one, which moves to the end: the order stays random. */
  add(x: number, y: number, z: number, above_m: number, sequence: number): void {
    const { position, seen, low, high } = this;
    const last = 3 * this.count;
    const at = 3 * Math.floor(Math.random() * (this.count + 1));
    position[last] = position[at];
    position[last + 1] = position[at + 1];
    position[last + 2] = position[at + 2];
    position[at] = x;
    position[at + 1] = y;
    position[at + 2] = z;
    const [seenLast, seenAt] = [2 * this.count, (2 * at) / 3];
    seen[seenLast] = seen[seenAt];
    seen[seenLast + 1] = seen[seenAt + 1];
    seen[seenAt] = above_m;
    seen[seenAt + 1] = sequence;
    this.count++;
    low.set(Math.min(low.x, x), Math.min(low.y, y), Math.min(low.z, z));
    high.set(Math.max(high.x, x), Math.max(high.y, y), Math.max(high.z, z));
  }

  /** After points were added. */
  publish(): void {
    const { geometry } = this.points;
    geometry.attributes.position.needsUpdate = true;
    geometry.attributes.seen.needsUpdate = true;
    geometry.setDrawRange(0, this.count);
    geometry.boundingSphere!.center.addVectors(this.low, this.high).multiplyScalar(0.5);
    geometry.boundingSphere!.radius = this.low.distanceTo(this.high) / 2;
  }

  at(index: number, out: Vector3): Vector3 {
    return out.fromArray(this.position, 3 * index);
  }

  above_m(index: number): number {
    return this.seen[2 * index];
  }

  /** The keyframe that saw it. */
  sequence(index: number): number {
    return this.seen[2 * index + 1];
  }

  dispose(): void {
    this.points.removeFromParent();
    this.points.geometry.dispose();
  }
}

export interface Taken {
  blocks: number;
  points: number;
}

/** Reads the blocks of GET /api/v1/sessions/ID/points; `next` gives a chunk that has room, `reach` is told of every point. */
export function takeBlocks(bytes: ArrayBuffer, next: () => Chunk, reach: Reach): Taken {
  const data = new DataView(bytes);
  const taken: Taken = { blocks: 0, points: 0 };
  const touched = new Set<Chunk>();
  for (let at = 0; at + headBytes <= data.byteLength; taken.blocks++) {
    const sequence = data.getUint32(at, true);
    const count = data.getUint32(at + 4, true);
    const [x, y, z] = [8, 12, 16].map((offset) => data.getFloat32(at + offset, true));
    at += headBytes;
    for (let i = 0; i < count; i++, at += pointBytes) {
      const chunk = next();
      touched.add(chunk);
      const up = unit_m * data.getInt16(at + 4, true);
      const [px, py] = [x + unit_m * data.getInt16(at, true), y + unit_m * data.getInt16(at + 2, true)];
      chunk.add(px, py, z + up, up, sequence);
      reach.take(px, py);
    }
    taken.points += count;
  }
  for (const chunk of touched) chunk.publish();
  return taken;
}
