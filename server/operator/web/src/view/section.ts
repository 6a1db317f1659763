// The points along the line that was picked, gathered from all clouds; anew when the line or the points are others.

import { Vector3 } from 'three';
import type { Transform } from '../station/types';
import type { Clouds } from './clouds';
import type { Frames } from './frames';
import { moved } from './grid';
import { type Flat, Profile } from './profile';

export interface Section {
  profile: Profile;
  component: number;
  /** Corners of the line, in the component's frame. */
  ends: Flat[];
}

export interface Wanted {
  component: number;
  members: number[];
  offset: Flat; // of the component's origin, as the view draws it
  corners: Vector3[]; // as the view draws them
  width_m: number;
  slice_m: [number, number] | null;
  T_grid_component: Transform | null;
}

const again_ms = 1000; // while points still come

export class SectionMaker {
  private made: Section | null = null;
  private basis = '';
  private points = 0;
  private madeAt = 0;

  constructor(
    private readonly clouds: Clouds,
    private readonly frames: Frames,
  ) {}

  /** Roof and clip do not hold here: a section shows the roof too. */
  of(wanted: Wanted): Section {
    const { component, members, offset, corners, width_m, slice_m, T_grid_component: T } = wanted;
    const shown = members.map((id) => this.clouds.clouds.get(id)?.lastShown);
    const basis = JSON.stringify([component, members, corners.map(({ x, y }) => [x, y]), width_m, slice_m, T, shown]);
    const points = this.clouds.loadedPoints;
    if (this.made && basis === this.basis && (points === this.points || performance.now() - this.madeAt < again_ms)) return this.made;
    const ends = corners.map(({ x, y }) => ({ x: x - offset.x, y: y - offset.y }));
    const profile = new Profile(ends, width_m);
    const p = new Vector3();
    for (const id of members) {
      const [cloud, place] = [this.clouds.clouds.get(id), this.frames.of(id)];
      if (!cloud || !place) continue;
      for (const [chunk] of cloud.chunks())
        for (let at = 0; at < chunk.count; at++) {
          if (chunk.sequence(at) > cloud.lastShown) continue;
          const { x, y, z } = chunk.at(at, p).applyMatrix4(place);
          if (slice_m && (z < slice_m[0] || z > slice_m[1])) continue;
          const [cx, cy] = [x - offset.x, y - offset.y];
          profile.take(cx, cy, z, T ? moved(T, cx, cy, z)[2] : z, id);
        }
    }
    [this.basis, this.points, this.madeAt] = [basis, points, performance.now()];
    this.made = { profile, component, ends };
    return this.made;
  }
}
