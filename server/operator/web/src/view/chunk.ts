// Some thousand points that are drawn with one call, in random order: any first part of them is an even sample.

import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Points, type ShaderMaterial, Sphere, Vector3 } from 'three';

export const chunkPoints = 16384;
const unit_m = 0.005;
const headBytes = 20;
const pointBytes = 6;

export class Chunk {
  readonly points: Points;
  count = 0;
  private readonly position = new Float32Array(3 * chunkPoints);
  private readonly seen = new Float32Array(2 * chunkPoints);
  private readonly low = new Vector3(Infinity, Infinity, Infinity);
  private readonly high = new Vector3(-Infinity, -Infinity, -Infinity);

  constructor(material: ShaderMaterial) {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(this.position, 3).setUsage(DynamicDrawUsage));
    geometry.setAttribute('seen', new BufferAttribute(this.seen, 2).setUsage(DynamicDrawUsage));
    geometry.boundingSphere = new Sphere();
    this.points = new Points(geometry, material);
    this.points.matrixAutoUpdate = false;
  }

  /** The new point takes the place of a random one, which moves to the end: the order stays random. */
  add(x: number, y: number, z: number, above_m: number, sequence: number): void {
    const { position, seen } = this;
    const at = Math.floor(Math.random() * (this.count + 1));
    position.copyWithin(3 * this.count, 3 * at, 3 * at + 3);
    seen.copyWithin(2 * this.count, 2 * at, 2 * at + 2);
    position[3 * at] = x;
    position[3 * at + 1] = y;
    position[3 * at + 2] = z;
    seen[2 * at] = above_m;
    seen[2 * at + 1] = sequence;
    this.count++;
    this.low.set(Math.min(this.low.x, x), Math.min(this.low.y, y), Math.min(this.low.z, z));
    this.high.set(Math.max(this.high.x, x), Math.max(this.high.y, y), Math.max(this.high.z, z));
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

  dispose(): void {
    this.points.removeFromParent();
    this.points.geometry.dispose();
  }
}

export interface Taken {
  blocks: number;
  points: number;
  lastSequence: number;
}

/** Reads the blocks of GET /api/v1/sessions/ID/points; `next` gives a chunk that has room. */
export function takeBlocks(bytes: ArrayBuffer, next: () => Chunk): Taken {
  const data = new DataView(bytes);
  const taken: Taken = { blocks: 0, points: 0, lastSequence: 0 };
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
      chunk.add(x + unit_m * data.getInt16(at, true), y + unit_m * data.getInt16(at + 2, true), z + up, up, sequence);
    }
    taken.points += count;
    taken.lastSequence = Math.max(taken.lastSequence, sequence);
  }
  for (const chunk of touched) chunk.publish();
  return taken;
}
