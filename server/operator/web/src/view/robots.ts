// Where robots are and where they came from: an arrow at the last pose, a line along the path.

import { BufferGeometry, Float32BufferAttribute, Group, Mesh, MeshBasicMaterial, Quaternion, Vector3, DoubleSide } from 'three';
import { Line2 } from 'three/addons/lines/Line2.js';
import { LineGeometry } from 'three/addons/lines/LineGeometry.js';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import type { Station } from '../station/station';
import type { Keyframe, Session, Transform } from '../station/types';
import { momentOf, saidSince } from '../time/moment';
import type { Frames } from './frames';
import type { Stage } from './stage';

const marker_px = 13;

function arrowGeometry(scale: number): BufferGeometry {
  const outline = [1.25, 0, -0.85, 0.8, -0.45, 0, -0.85, -0.8].map((value) => value * scale);
  const [ax, ay, bx, by, cx, cy, dx, dy] = outline;
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute([ax, ay, 0, bx, by, 0, cx, cy, 0, ax, ay, 0, cx, cy, 0, dx, dy, 0], 3));
  return geometry;
}

const inner = arrowGeometry(1);
const outer = arrowGeometry(1.5);

class Robot {
  readonly group = new Group();
  private readonly rim = new MeshBasicMaterial({ side: DoubleSide, depthTest: false });
  private readonly body = new MeshBasicMaterial({ side: DoubleSide, depthTest: false });
  private readonly material = new LineMaterial({ linewidth: 2, depthTest: false, transparent: true, opacity: 0.9 });
  private readonly marker = new Group();
  private trail: Line2 | null = null;
  private path: Keyframe[] = [];

  constructor() {
    this.group.matrixAutoUpdate = false;
    const [rim, body] = [new Mesh(outer, this.rim), new Mesh(inner, this.body)];
    rim.renderOrder = 20;
    body.renderOrder = 21;
    this.marker.add(rim, body);
    this.marker.visible = false;
    this.group.add(this.marker);
  }

  follow(path: Keyframe[]): void {
    if (path === this.path || path.length === 0) return;
    this.path = path;
    if (path.length < 2) return;
    this.trail?.geometry.dispose();
    const geometry = new LineGeometry().setPositions(path.flatMap((keyframe) => keyframe.position));
    if (!this.trail) {
      this.trail = new Line2(geometry, this.material);
      this.trail.renderOrder = 10;
      this.group.add(this.trail);
    }
    this.trail.geometry = geometry;
  }

  paint(colour: string, paper: string, rim: string, connected: boolean, faded: number): void {
    this.body.color.setStyle(connected ? colour : paper, 'srgb-linear');
    this.rim.color.setStyle(connected ? rim : colour, 'srgb-linear');
    this.material.color.setStyle(colour, 'srgb-linear');
    this.material.opacity = 0.9 * (1 - faded);
    this.material.linewidth = faded > 0 ? 1.5 : 2.5;
  }

  /** Where it was when it had made so many of its keyframes and `share` of the way to the next, and after the last where
   * it says that it is; nowhere before the first. */
  show(count: number, share: number, T_session_sensor: Transform | null): void {
    this.group.visible = count > 0;
    if (count === 0) return;
    this.marker.visible = true;
    const at = Math.min(count, this.path.length) - 1;
    const [from, to] = [this.path[at], this.path[Math.min(at + 1, this.path.length - 1)]];
    this.marker.position.fromArray(from.position).lerp(new Vector3(...to.position), share);
    // Flat, as a map's arrow: only the heading is shown.
    const turned = new Quaternion(...from.quaternion).slerp(new Quaternion(...to.quaternion), share);
    const ahead = new Vector3(1, 0, 0).applyQuaternion(turned);
    this.marker.rotation.set(0, 0, Math.atan2(ahead.y, ahead.x));
    if (T_session_sensor && at === this.path.length - 1) {
      const [xx, , , x, yx, , , y, , , , z] = T_session_sensor;
      this.marker.position.set(x, y, z);
      this.marker.rotation.z = Math.atan2(yx, xx);
    }
    if (this.trail) this.trail.geometry.instanceCount = at;
  }

  get p_session(): Vector3 {
    return this.marker.position;
  }

  place(stage: Stage): void {
    const scale = marker_px * stage.metresPerPixel(this.marker.getWorldPosition(new Vector3()));
    this.marker.scale.setScalar(scale / 2);
  }

  dispose(): void {
    this.trail?.geometry.dispose();
    this.material.dispose();
    this.rim.dispose();
    this.body.dispose();
    this.group.removeFromParent();
  }
}

export class Robots {
  private readonly robots = new Map<number, Robot>();

  constructor(
    private readonly station: Station,
    private readonly frames: Frames,
    private readonly stage: Stage,
  ) {}

  sync(paint: (session: Session) => { colour: string; paper: string; rim: string; faded: number }): void {
    for (const [id, session] of this.station.sessions) {
      let robot = this.robots.get(id);
      if (!robot) {
        robot = new Robot();
        this.robots.set(id, robot);
        this.stage.signs.add(robot.group);
      }
      robot.follow(this.station.paths.get(id) ?? []);
      const { colour, paper, rim, faded } = paint(session);
      robot.paint(colour, paper, rim, session.connected, faded);
    }
    for (const [id, robot] of this.robots)
      if (!this.station.sessions.has(id)) {
        robot.dispose();
        this.robots.delete(id);
      }
  }

  /** As of the moment that `untilOf` says for each session. */
  beforeFrame(untilOf: (session: number) => number): void {
    for (const [id, robot] of this.robots) {
      const T = this.frames.of(id);
      const path = this.station.paths.get(id) ?? [];
      robot.show(...momentOf(path, untilOf(id)), saidSince(path, this.station.sessions.get(id)));
      if (!T) robot.group.visible = false;
      if (!T || !robot.group.visible) continue;
      robot.group.matrix.copy(T);
      robot.group.updateMatrixWorld(true);
      robot.place(this.stage);
    }
  }

  /** Of the arrow, as drawn. */
  positionOf(session: number): Vector3 | undefined {
    const T = this.frames.of(session);
    const robot = this.robots.get(session);
    return T && robot?.group.visible ? robot.p_session.clone().applyMatrix4(T) : undefined;
  }
}
