// When points were seen, as shares of all the time that the map spans: for their colours. Pure.

import { wallClock_s } from '../parts/format';
import type { Keyframe } from '../station/types';

export interface Ages {
  oldest_s: number;
  newest_s: number;
}

/** Sessions whose clocks tell the date count alone where there are any: others lie before them all. */
export function agesOf(paths: Iterable<Keyframe[]>): Ages {
  const driven = [...paths].filter((path) => path.length > 0);
  const dated = driven.filter(([first]) => first.stamp_s > wallClock_s);
  const counted = dated.length > 0 ? dated : driven;
  if (counted.length === 0) return { oldest_s: 0, newest_s: 1 };
  return { oldest_s: Math.min(...counted.map((path) => path[0].stamp_s)), newest_s: Math.max(...counted.map((path) => path.at(-1)!.stamp_s)) };
}

/** What keyframe number 0 would have, and what each further one adds; a robot makes keyframes about evenly. */
export function sharesOf(path: Keyframe[], { oldest_s, newest_s }: Ages): [number, number] {
  if (path.length === 0) return [0, 0];
  const share = (stamp_s: number) => (stamp_s - oldest_s) / Math.max(newest_s - oldest_s, 1e-3);
  const [first, last] = [path[0], path.at(-1)!];
  const each = (share(last.stamp_s) - share(first.stamp_s)) / Math.max(last.sequence - first.sequence, 1);
  return [share(first.stamp_s) - each * first.sequence, each];
}
