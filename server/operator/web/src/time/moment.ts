// Where a robot is at a moment. Pure.

import type { Keyframe, Session, Transform } from '../station/types';
import { countUntil } from './axis';

/** Where a robot says that it is, unless its last keyframe is newer. */
export function saidSince(path: Keyframe[], session: Session | undefined): Transform | null {
  const live = session?.connected ? session.live : null;
  return live && live.stamp_s >= (path.at(-1)?.stamp_s ?? Infinity) ? live.T_session_sensor : null;
}

/** How many keyframes there were, and the share of the way to the next. */
export function momentOf(path: Keyframe[], until_s: number): [number, number] {
  const count = countUntil(path, until_s);
  if (count === 0 || count === path.length) return [count, 0];
  const [from_s, to_s] = [path[count - 1].stamp_s, path[count].stamp_s];
  return [count, (until_s - from_s) / (to_s - from_s)];
}
