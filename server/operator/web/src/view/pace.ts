// How many points a frame may have, learnt from how long frames take. Pure.

const steepest = 0.25; // of what is drawn, from one frame to the next
const growth = 1.1;

export interface Limits {
  late_ms: number; // slower frames get fewer points
  aim_ms: number;
  swift_ms: number; // faster ones get more
}

/** While the operator moves the view, and while it stands still. */
export const moving: Limits = { late_ms: 70, aim_ms: 50, swift_ms: 34 };
export const still: Limits = { late_ms: 1000, aim_ms: 700, swift_ms: 500 };

export class Pace {
  points: number;

  constructor(
    private readonly limits: Limits,
    private readonly least: number,
    private readonly most: number,
  ) {
    this.points = most;
  }

  /** A frame with so many points took so long. */
  took(frame_ms: number, drawn: number): void {
    const { late_ms, aim_ms, swift_ms } = this.limits;
    if (frame_ms > late_ms) this.points = Math.max(this.least, Math.max(steepest, aim_ms / frame_ms) * Math.min(this.points, drawn));
    else if (frame_ms < swift_ms) this.points = Math.min(this.most, growth * this.points);
  }
}
