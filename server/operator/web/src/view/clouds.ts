// All clouds: which level of detail each gets, and how many points are drawn of what is there.

import { Frustum, Matrix4, Scene, Vector3 } from 'three';
import { early } from '../station/overview';
import type { Station } from '../station/station';
import type { Chunk } from './chunk';
import { shared } from './cloud_material';
import type { Frames } from './frames';
import { moving, Pace, still } from './pace';
import { levelCube_m, SessionCloud } from './session_cloud';
import type { Stage } from './stage';

const pointsAtOnce = 60_000;
const growth = 4; // points of a level against the coarser one, about
const growingLevel = 2; // while a session still grows: finer ones cost the server more than they show
const settled_ms = 6000;
const again_ms = 400; // between two requests for a session that grows

export interface Budget {
  loaded: number;
  drawn: number;
  leastDrawn: number;
}

export class Clouds {
  readonly clouds = new Map<number, SessionCloud>();
  drawnPoints = 0;
  private readonly grewAt = new Map<number, { clouds: number; at: number }>();
  private readonly fetchedAt = new Map<number, number>();
  private readonly movingPace: Pace;
  private readonly stillPace: Pace;

  constructor(
    private readonly scene: Scene,
    private readonly station: Station,
    private readonly frames: Frames,
    private readonly stage: Stage,
    readonly budget: Budget,
  ) {
    this.movingPace = new Pace(moving, budget.leastDrawn, budget.drawn);
    this.stillPace = new Pace(still, budget.leastDrawn, budget.drawn);
    setInterval(() => this.fetchNext(), 250);
  }

  get loadedPoints(): number {
    let sum = 0;
    for (const cloud of this.clouds.values()) sum += cloud.points;
    return sum;
  }

  /** Changes whenever points reach further than before. */
  get reached(): number {
    let sum = 0;
    for (const { reach } of this.clouds.values()) sum += reach.version;
    return sum;
  }

  sync(): void {
    for (const [id, cloud] of this.clouds)
      if (!this.station.sessions.has(id) || this.station.shortened.delete(id)) {
        cloud.dispose();
        this.clouds.delete(id);
      }
    for (const [id, { clouds }] of this.station.sessions) {
      if (!this.clouds.has(id)) {
        const cloud = new SessionCloud(id, () => this.stage.draw());
        this.clouds.set(id, cloud);
        this.scene.add(cloud.group);
      }
      if (this.grewAt.get(id)?.clouds !== clouds) {
        // What was there when the page opened is not growing.
        this.grewAt.set(id, { clouds, at: this.grewAt.has(id) ? performance.now() : -settled_ms });
      }
    }
    this.fetchNext();
  }

  paint(colourOf: (session: number) => { colour: string; faded: number; ages: [number, number] }): void {
    for (const [id, cloud] of this.clouds) {
      const { colour, faded, ages } = colourOf(id);
      cloud.paint(colour, faded, ages);
    }
  }

  /** Points that `lastOf` says a session saw later are left out. */
  showUntil(lastOf: (session: number) => number): void {
    for (const [id, cloud] of this.clouds) cloud.show(lastOf(id));
  }

  /** Matrices, and the share of every chunk that is drawn: as dense as the pixels ask, as many as the budget allows. */
  beforeFrame(): void {
    shared.pixelsPerUnit.value = this.stage.pixelsPerUnit();
    shared.perspective.value = this.stage.way === 'free' ? 1 : 0;
    const { camera } = this.stage;
    const frustum = new Frustum().setFromProjectionMatrix(new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse));
    const wanted: { chunk: Chunk; count: number }[] = [];
    let total = 0;
    const centre = new Vector3();
    for (const [id, cloud] of this.clouds) {
      const T = this.frames.of(id);
      cloud.group.visible = T !== undefined;
      if (!T) continue;
      for (const [chunk, cube_m] of cloud.chunks()) {
        if (!chunk.points.matrixWorld.equals(T)) chunk.points.matrixWorld.copy(T);
        chunk.points.matrixWorldAutoUpdate = false;
        if (!frustum.intersectsObject(chunk.points)) continue;
        centre.copy(chunk.points.geometry.boundingSphere!.center).applyMatrix4(T);
        const apart_px = cube_m / this.stage.metresPerPixel(centre);
        const count = Math.ceil(chunk.count * Math.min(1, 2 * apart_px * apart_px));
        wanted.push({ chunk, count });
        total += count;
      }
    }
    const most = (this.stage.moves ? this.movingPace : this.stillPace).points;
    const share = Math.min(1, most / Math.max(total, 1));
    this.drawnPoints = 0;
    for (const { chunk, count } of wanted) {
      const drawn = Math.floor(count * share);
      chunk.points.geometry.setDrawRange(0, drawn);
      this.drawnPoints += drawn;
    }
  }

  /** A frame took so long until the graphics card was done with it. */
  tookFrame(frame_ms: number, drawn: number, moved: boolean): void {
    (moved ? this.movingPace : this.stillPace).took(frame_ms, drawn);
  }

  /** Starts what is most wanted: first something of every session, then what came since, then finer levels. */
  private fetchNext(): void {
    const now = performance.now();
    const { epoch } = this.station;
    const target = this.stage.target;
    const rows = [...this.clouds.values()].filter(({ id, idle }) => idle && this.station.link !== 'away' && this.station.sessions.has(id));
    const distance = (cloud: SessionCloud) => {
      const T = this.frames.of(cloud.id);
      const path = this.station.paths.get(cloud.id);
      const middle = path?.[path.length >> 1];
      return T && middle ? new Vector3(...middle.position).applyMatrix4(T).distanceTo(target) : Infinity;
    };
    for (const cloud of rows) {
      if (!this.station.paths.has(cloud.id)) continue; // it would be drawn where it does not stay
      const { clouds } = this.station.sessions.get(cloud.id)!;
      const there = this.station.takeEarlyPoints(cloud.id);
      const rested = now - (this.fetchedAt.get(cloud.id) ?? -again_ms) >= again_ms;
      const wanted = cloud.level < 0 ? early.level : cloud.level;
      if (there && cloud.level < 0) {
        cloud.begin(early.level, epoch, there);
        this.fetchedAt.set(cloud.id, now);
      } else if (rested && cloud.lacks(wanted, clouds, epoch)) this.fetch(cloud, wanted, clouds);
    }
    if (rows.length < [...this.clouds.keys()].filter((id) => this.station.sessions.has(id)).length || this.drawnPoints === 0) return; // other levels wait until nothing else is on its way
    if (this.loadedPoints > this.budget.loaded) {
      const coarser = rows.filter((cloud) => cloud.idle && cloud.level > 0).sort((x, y) => y.level - x.level || distance(y) - distance(x))[0];
      if (coarser) {
        coarser.finest = coarser.level - 1;
        this.fetch(coarser, coarser.finest, this.station.sessions.get(coarser.id)!.clouds);
      }
      return;
    }
    const finer = rows
      .filter((cloud) => cloud.idle && cloud.level >= 0 && cloud.level < Math.min(cloud.finest, this.finest(cloud.id, now)))
      .sort((x, y) => x.level - y.level || distance(x) - distance(y))
      .find((cloud) => this.loadedPoints + growth * cloud.points <= this.budget.loaded);
    if (finer) this.fetch(finer, finer.level + 1, this.station.sessions.get(finer.id)!.clouds);
  }

  private finest(id: number, now: number): number {
    return now - (this.grewAt.get(id)?.at ?? 0) < settled_ms ? growingLevel : levelCube_m.length - 1;
  }

  private fetch(cloud: SessionCloud, level: number, clouds: number): void {
    this.fetchedAt.set(cloud.id, performance.now());
    const atOnce = Math.ceil(cloud.level < 0 ? early.points : Math.min(pointsAtOnce, this.budget.loaded / 8));
    void cloud.fetch(level, clouds, this.station.epoch, atOnce, () => this.loadedPoints + atOnce <= this.budget.loaded).then(() => this.fetchNext());
  }
}
