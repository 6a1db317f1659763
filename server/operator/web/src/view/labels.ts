// Text over the canvas, as elements of the page: sharp, selectable by keyboard, read out. Those that would lie over a
// more important one are left out.

import type { Vector3 } from 'three';
import type { Stage } from './stage';

export interface Label {
  key: string;
  place: Vector3;
  text: string;
  kind: 'robot' | 'away' | 'frame' | 'verdict' | 'measure';
  colour?: string;
  rank: number; // smaller ones are drawn first
  describe?: string;
  onClick?: () => void;
}

/** Pixels between a place and the text over it. */
const over: Record<Label['kind'], number> = { robot: 18, away: 18, frame: 1, verdict: 0, measure: 0 };

interface Shown {
  element: HTMLElement;
  label: Label;
  width: number;
  height: number;
}

export class Labels {
  private readonly shown = new Map<string, Shown>();

  constructor(
    private readonly layer: HTMLElement,
    private readonly stage: Stage,
  ) {}

  set(labels: Label[]): void {
    const keys = new Set(labels.map(({ key }) => key));
    for (const [key, { element }] of this.shown)
      if (!keys.has(key)) {
        element.remove();
        this.shown.delete(key);
      }
    for (const label of labels) this.put(label);
  }

  place(): void {
    const taken: [number, number, number, number][] = [];
    const rows = [...this.shown.values()].sort((x, y) => x.label.rank - y.label.rank);
    for (const { element, label, width, height } of rows) {
      const { x, y, z } = this.stage.toPage(label.place);
      const wanted = label.kind === 'frame' ? Math.min(x, this.stage.size.x - width - 4) : x - width / 2;
      const left = Math.round(x < this.stage.size.x ? wanted : x);
      const top = Math.round(y - over[label.kind] - (label.kind === 'frame' ? height : height / 2));
      const outside = z > 1 || left + width < 0 || top + height < 0 || left > this.stage.size.x || top > this.stage.size.y;
      const hidden = outside || taken.some(([l, t, r, b]) => left < r && left + width > l && top < b && top + height > t);
      element.style.visibility = hidden ? 'hidden' : 'visible';
      element.style.transform = `translate(${left}px, ${top}px)`;
      if (!hidden) taken.push([left - 2, top - 1, left + width + 2, top + height + 1]);
    }
  }

  private put(label: Label): void {
    const known = this.shown.get(label.key);
    if (known && known.label.text === label.text && known.label.kind === label.kind && known.label.colour === label.colour) {
      known.label = label;
      return;
    }
    const element = known?.element ?? document.createElement(label.onClick ? 'button' : 'div');
    element.className = `label label-${label.kind}`;
    element.textContent = label.text;
    element.style.setProperty('--mark', label.colour ?? 'currentColor');
    if (label.describe) element.setAttribute('aria-label', label.describe);
    element.onclick = () => this.shown.get(label.key)?.label.onClick?.();
    if (!known) this.layer.append(element);
    this.shown.set(label.key, { element, label, width: element.offsetWidth, height: element.offsetHeight });
  }
}
