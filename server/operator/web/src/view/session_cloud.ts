// The points of one session: a level of detail that is shown, and perhaps a finer one that is on its way.

import { Group, type ShaderMaterial } from 'three';
import { inTurn, points } from '../station/api';
import { Chunk, takeBlocks } from './chunk';
import { cloudMaterial, vector } from './cloud_material';
import { Reach } from './reach';

export const levelCube_m = [2, 1, 0.5, 0.25, 0.1];

class Level {
  readonly group = new Group();
  readonly chunks: Chunk[] = [];
  readonly material: ShaderMaterial = cloudMaterial();
  blocks = 0;
  points = 0;

  constructor(readonly level: number) {
    this.material.uniforms.cube.value = 1.15 * levelCube_m[level];
    this.group.matrixAutoUpdate = false;
  }

  take(bytes: ArrayBuffer, reach: Reach): number {
    const taken = takeBlocks(bytes, () => this.room(), reach);
    this.blocks += taken.blocks;
    this.points += taken.points;
    return taken.points;
  }

  dispose(): void {
    for (const chunk of this.chunks) chunk.dispose();
    this.material.dispose();
    this.group.removeFromParent();
  }

  private room(): Chunk {
    const last = this.chunks.at(-1);
    if (last && !last.isFull) return last;
    const chunk = new Chunk(this.material, !last);
    this.group.add(chunk.points);
    this.chunks.push(chunk);
    return chunk;
  }
}

export class SessionCloud {
  readonly group = new Group();
  /** Of all points that were there so far. */
  readonly reach = new Reach();
  /** Clouds that the server had when blocks were last asked for. */
  private seenClouds = 0;
  private epoch = 0;
  private busy = false;
  /** The finest level for which there was room. */
  finest = levelCube_m.length - 1;
  private shown: Level | null = null;
  private coming: Level | null = null;
  private colour = '#888888';
  private faded = 0;
  private ages: [number, number] = [0, 0];
  private until = Infinity;

  constructor(
    readonly id: number,
    private readonly onPoints: () => void,
  ) {
    this.group.matrixAutoUpdate = false;
  }

  get level(): number {
    return this.shown?.level ?? -1;
  }
  get points(): number {
    return (this.shown?.points ?? 0) + (this.coming?.points ?? 0);
  }
  get idle(): boolean {
    return !this.busy;
  }
  get cube_m(): number {
    return levelCube_m[Math.max(this.level, 0)];
  }
  /** With their cubes' size, so that a nearer look can ask for more of them. */
  *chunks(): Generator<[Chunk, number]> {
    for (const level of [this.shown, this.coming])
      if (level) for (const chunk of level.chunks) yield [chunk, levelCube_m[level.level]];
  }

  /** The last keyframe whose points are shown. */
  get lastShown(): number {
    return this.until;
  }

  show(until: number): void {
    this.until = until;
    for (const level of [this.shown, this.coming]) if (level) level.material.uniforms.until.value = Math.min(until, 1e9);
  }

  /** `ages` as sharesOf() has them. */
  paint(colour: string, faded: number, ages: [number, number]): void {
    this.colour = colour;
    this.faded = faded;
    this.ages = ages;
    for (const level of [this.shown, this.coming]) if (level) this.dress(level);
  }

  /** Whether there is something to fetch for this level. */
  lacks(level: number, clouds: number, epoch: number): boolean {
    return clouds > 0 && (level !== this.level || clouds !== this.seenClouds || epoch !== this.epoch);
  }

  /** Shows what came with the overview; what it lacks is fetched later. */
  begin(level: number, epoch: number, bytes: ArrayBuffer): void {
    this.shown = this.add(level);
    this.epoch = epoch;
    this.shown.take(bytes, this.reach);
    this.onPoints();
  }

  /** Fetches what is new at the level that is shown, or all of another one, which then takes its place; given up, if
   * finer, once there is no room. */
  async fetch(level: number, clouds: number, epoch: number, pointsAtOnce: number, room: () => boolean): Promise<void> {
    this.busy = true;
    try {
      const anew = level !== this.level || epoch !== this.epoch;
      const into = anew ? (this.coming = this.add(level)) : this.shown!;
      for (;;) {
        const taken = into.take(await inTurn(() => points(this.id, into.level, into.blocks, pointsAtOnce)), this.reach);
        this.onPoints();
        if (taken < pointsAtOnce) break;
        if (level > this.level && this.level >= 0 && !room()) {
          this.finest = this.level;
          throw new Error('no room for a finer level');
        }
      }
      if (anew) {
        this.shown?.dispose();
        this.shown = into;
        this.coming = null;
      }
      this.seenClouds = clouds;
      this.epoch = epoch;
    } catch {
      this.coming?.dispose();
      this.coming = null;
    } finally {
      this.busy = false;
      this.onPoints();
    }
  }

  dispose(): void {
    this.shown?.dispose();
    this.coming?.dispose();
    this.group.removeFromParent();
  }

  private add(number: number): Level {
    const level = new Level(number);
    this.dress(level);
    this.group.add(level.group);
    return level;
  }

  private dress(level: Level): void {
    level.material.uniforms.ink.value = vector(this.colour);
    level.material.uniforms.faded.value = this.faded;
    level.material.uniforms.ages.value.set(...this.ages);
    level.material.uniforms.until.value = Math.min(this.until, 1e9);
  }
}
