// What changed in the mine, on the map: a ring as wide and as high as what is gone or new, with its name. It follows the
// sessions that tell of it.

import { CircleGeometry, DoubleSide, Group, Matrix4, Mesh, MeshBasicMaterial, Vector3 } from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';
import { changeKey, changeLooks, changesSince, changeSize } from '../station/changes';
import type { Station } from '../station/station';
import type { Change, SeenBy } from '../station/types';
import type { Frames } from './frames';
import type { Label } from './labels';
import { matrixOf } from './layout';
import type { Stage } from './stage';

const corners = 48; // of a ring
const least_m = 0.5; // radius: what is smaller would not be seen

interface Mark {
  change: Change;
  group: Group;
  line: LineSegments2;
  patch: Mesh<CircleGeometry, MeshBasicMaterial>;
}

export class ChangeMarks {
  private readonly marks = new Map<string, Mark>();
  private changes: Change[] = [];

  constructor(
    private readonly stage: Stage,
    private readonly frames: Frames,
    private readonly station: Station,
  ) {}

  sync(isDark: boolean, selected: string | null): void {
    if (this.station.changes !== this.changes) this.rebuild(this.station.changes);
    for (const [key, { change, line, patch }] of this.marks) {
      const colour = changeLooks[change.kind][isDark ? 'dark' : 'light'];
      line.material.color.setStyle(colour, 'srgb-linear');
      line.material.linewidth = key === selected ? 3.5 : 2;
      patch.material.color.setStyle(colour, 'srgb-linear');
      patch.material.opacity = key === selected ? 0.35 : 0.18;
    }
  }

  /** As the view draws it; null: its sessions are in no one map any more. */
  placeOf({ p, older, newer }: Change): Vector3 | null {
    const [placed, other] = [older, newer].map(({ id }) => this.station.placed.get(id));
    const T_world_session = this.frames.of(older.id);
    if (!placed || !T_world_session || other?.component !== placed.component) return null;
    const T_session_component = matrixOf(placed.T_component_session).invert();
    return new Vector3(...p).applyMatrix4(new Matrix4().multiplyMatrices(T_world_session, T_session_component));
  }

  /** Those that are wanted and that `seen` says had been seen at the moment that is shown. */
  beforeFrame({ changes, changesFrom }: { changes: boolean; changesFrom: string }, seen: (newer: SeenBy) => boolean): void {
    const wanted = new Set(changes ? changesSince(this.changes, changesFrom) : []);
    for (const { change, group } of this.marks.values()) {
      const place = wanted.has(change) && seen(change.newer) ? this.placeOf(change) : null;
      group.visible = place !== null;
      if (place) group.position.copy(place);
    }
  }

  labels(selected: string | null, onClick: (key: string) => void): Label[] {
    return [...this.marks].flatMap(([key, { change, group, line }]) => {
      if (!group.visible) return [];
      const text = `${changeLooks[change.kind].sign} ${change.kind}`;
      const describe = `Change: ${change.kind}, ${changeSize(change)}; show it in the list`;
      const colour = `#${line.material.color.getHexString('srgb-linear')}`;
      return [{ key: `change-${key}`, place: group.position.clone(), text, kind: 'change' as const, colour, rank: key === selected ? 1 : 3, describe, onClick: () => onClick(key) }];
    });
  }

  private rebuild(changes: Change[]): void {
    for (const { group, line, patch } of this.marks.values()) {
      for (const drawn of [line, patch]) {
        drawn.geometry.dispose();
        drawn.material.dispose();
      }
      group.removeFromParent();
    }
    this.marks.clear();
    this.changes = changes;
    for (const change of changes) this.marks.set(changeKey(change), this.markOf(change));
  }

  private markOf(change: Change): Mark {
    const radius_m = Math.max(Math.max(change.size_m[0], change.size_m[1]) / 2, least_m);
    const line = new LineSegments2(new LineSegmentsGeometry().setPositions(ringsOf(radius_m, change.size_m[2])), new LineMaterial({ depthTest: false, transparent: true }));
    const patch = new Mesh(new CircleGeometry(radius_m, corners), new MeshBasicMaterial({ depthTest: false, transparent: true, side: DoubleSide }));
    [patch.renderOrder, line.renderOrder] = [13, 14];
    patch.frustumCulled = line.frustumCulled = false;
    const group = new Group().add(patch, line);
    group.visible = false;
    this.stage.signs.add(group);
    return { change, group, line, patch };
  }
}

/** One ring at the foot, one at the top, and uprights between them; around the middle. */
function ringsOf(radius_m: number, height_m: number): number[] {
  const ends: number[] = [];
  const at = (index: number): [number, number] => [radius_m * Math.cos((2 * Math.PI * index) / corners), radius_m * Math.sin((2 * Math.PI * index) / corners)];
  const [foot, top] = [-height_m / 2, height_m / 2];
  for (let index = 0; index < corners; index++) {
    for (const z of [foot, top]) ends.push(...at(index), z, ...at(index + 1), z);
    if (index % (corners / 4) === 0) ends.push(...at(index), foot, ...at(index), top);
  }
  return ends;
}
