// Alignments: where two maps share rock, links between their paths; between maps that lie apart, one line.

import { Vector3 } from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';
import type { Station } from '../station/station';
import type { Alignment } from '../station/types';
import type { Frames } from './frames';
import { type Link, overlapLinks } from './overlap';
import { lookOf } from './palette';
import type { Stage } from './stage';

const recount = 8; // keyframes that a path grows before the overlap is looked for again

interface Edge {
  alignment: Alignment;
  basis: string;
  links: Link[];
  line: LineSegments2;
  drawnAt: number;
  badge: Vector3;
}

export class Edges {
  private readonly edges = new Map<number, Edge>();

  constructor(
    private readonly station: Station,
    private readonly frames: Frames,
    private readonly stage: Stage,
  ) {}

  /** Rejected ones are drawn when they are selected only. */
  sync(isDark: boolean, selected: number | null): void {
    const shown = [...this.station.alignments.values()].filter(({ id, state }) => state !== 'rejected' || id === selected);
    const ids = new Set(shown.map(({ id }) => id));
    for (const [id, edge] of this.edges)
      if (!ids.has(id)) {
        dispose(edge);
        this.edges.delete(id);
      }
    for (const alignment of shown) this.syncOne(alignment, isDark, alignment.id === selected);
  }

  private syncOne(alignment: Alignment, isDark: boolean, selected: boolean): void {
    const a = this.station.paths.get(this.station.idOf(alignment.a) ?? -1) ?? [];
    const b = this.station.paths.get(this.station.idOf(alignment.b) ?? -1) ?? [];
    const basis = [Math.ceil(a.length / recount), Math.ceil(b.length / recount), ...alignment.T_a_b].join();
    let edge = this.edges.get(alignment.id);
    if (!edge) {
      const material = new LineMaterial({ depthTest: false, transparent: true });
      const line = new LineSegments2(new LineSegmentsGeometry(), material);
      line.renderOrder = 12;
      line.frustumCulled = false;
      this.stage.signs.add(line);
      edge = { alignment, basis: '', links: [], line, drawnAt: -1, badge: new Vector3() };
      this.edges.set(alignment.id, edge);
    }
    edge.alignment = alignment;
    if (edge.basis !== basis) {
      edge.basis = basis;
      edge.drawnAt = -1;
      edge.links = overlapLinks(a, b, alignment.T_a_b);
      if (edge.links.length === 0 && a.length && b.length)
        edge.links = [{ p_a: new Vector3(...a[a.length >> 1].position), p_b: new Vector3(...b[b.length >> 1].position) }];
    }
    const look = lookOf(alignment);
    const { material } = edge.line;
    material.color.setStyle(isDark ? look.dark : look.light, 'srgb-linear');
    material.linewidth = selected ? 3 : 1.6;
    material.opacity = selected ? 1 : 0.75;
    if (material.dashed !== (look.dash !== null)) {
      material.dashed = look.dash !== null;
      material.needsUpdate = true;
    }
    if (look.dash) [material.dashSize, material.gapSize] = look.dash;
  }

  beforeFrame(): void {
    for (const edge of this.edges.values()) {
      if (edge.drawnAt === this.frames.version) continue;
      edge.drawnAt = this.frames.version;
      const [T_a, T_b] = [edge.alignment.a, edge.alignment.b].map((name) => this.frames.of(this.station.idOf(name) ?? -1));
      edge.line.visible = T_a !== undefined && T_b !== undefined && edge.links.length > 0;
      if (!edge.line.visible) continue;
      const apart = this.isApart(edge.alignment);
      const links = apart ? [edge.links[edge.links.length >> 1]] : edge.links;
      const ends = links.map(({ p_a, p_b }) => [p_a.clone().applyMatrix4(T_a!), p_b.clone().applyMatrix4(T_b!)]);
      edge.line.geometry.dispose();
      edge.line.geometry = new LineSegmentsGeometry().setPositions(ends.flatMap(([p, q]) => [...p.toArray(), ...q.toArray()]));
      edge.line.computeLineDistances();
      const [p, q] = ends[ends.length >> 1];
      edge.badge.addVectors(p, q).multiplyScalar(0.5);
    }
  }

  *badges(): Generator<[Alignment, Vector3]> {
    for (const { alignment, line, badge } of this.edges.values()) if (line.visible) yield [alignment, badge];
  }

  private isApart({ a, b }: Alignment): boolean {
    const [x, y] = [a, b].map((name) => this.station.placed.get(this.station.idOf(name) ?? -1)?.component);
    return x === undefined || x !== y;
  }
}

function dispose({ line }: Edge): void {
  line.geometry.dispose();
  line.material.dispose();
  line.removeFromParent();
}
