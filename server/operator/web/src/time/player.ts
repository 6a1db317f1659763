// The moment that the map is shown at: now, or an earlier one that is played on from.

import type { Station } from '../station/station';
import type { Ui } from '../ui';
import { TimeAxis } from './axis';

export const speeds = [1, 5, 20, 100, 500];
const aimed_s = 30; // that playing all takes with the speed chosen first

/** Plays the session that is selected, or all. */
export class Player {
  open = false;
  playing = false;
  speed = speeds[0];
  axis = new TimeAxis([]);
  private at_s = Infinity;
  private basis = '';
  private steppedAt = 0;
  private readonly listeners: (() => void)[] = [];

  constructor(
    private readonly station: Station,
    private readonly ui: Ui,
  ) {}

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }

  /** On the axis; at its end whatever comes is shown as it comes. */
  get position_s(): number {
    return Math.min(this.at_s, this.axis.length_s);
  }

  /** What this session saw later is not shown; Infinity: all is. */
  until(session: number): number {
    const { session: one } = this.ui.now;
    if (!this.open || this.at_s >= this.axis.length_s || (one !== null && one !== session)) return Infinity;
    return this.axis.toStamp(this.at_s);
  }

  /** Takes over what the station knows now, and what is selected. */
  sync(): void {
    if (!this.open) return;
    const { session: one } = this.ui.now;
    const paths = [...this.station.paths].filter(([id, path]) => path.length > 0 && (one === null || one === id));
    const basis = `${one}: ${paths.map(([id, path]) => `${id} ${path.length}`).join()}`;
    if (basis === this.basis) return;
    const other = !this.basis.startsWith(`${one}:`);
    const atEnd = this.at_s >= this.axis.length_s;
    const stamp_s = this.axis.toStamp(this.at_s);
    this.basis = basis;
    this.axis = new TimeAxis(paths.map(([, path]) => ({ from_s: path[0].stamp_s, to_s: path.at(-1)!.stamp_s })));
    this.at_s = atEnd || other ? Infinity : this.axis.toAxis(stamp_s); // the same moment, on another axis
    if (other) this.speed = speeds.find((speed) => this.axis.length_s / speed <= aimed_s) ?? speeds.at(-1)!;
    if (other) this.playing = false;
  }

  show(open: boolean): void {
    this.open = open;
    this.playing = false;
    this.at_s = Infinity;
    this.basis = '';
    this.sync();
    this.tell();
  }

  /** From the beginning when all was shown. */
  play(playing: boolean): void {
    if (playing && !this.open) this.show(true);
    if (playing && this.at_s >= this.axis.length_s) this.at_s = 0;
    this.playing = playing;
    this.steppedAt = performance.now();
    this.tell();
  }

  seek(at_s: number): void {
    this.at_s = at_s >= this.axis.length_s ? Infinity : Math.max(at_s, 0);
    this.tell();
  }

  setSpeed(speed: number): void {
    this.speed = speed;
    this.tell();
  }

  /** With each frame; whether there is another. */
  step(now: number): boolean {
    if (!this.playing) return false;
    this.at_s += (this.speed * Math.max(now - this.steppedAt, 0)) / 1000;
    this.steppedAt = now;
    if (this.at_s < this.axis.length_s) return true;
    this.at_s = Infinity;
    this.playing = false;
    this.tell();
    return false;
  }

  private tell(): void {
    for (const listener of this.listeners) listener();
  }
}
