// Sends where the operator laid a session, and says what came of it.

import { askJson } from '../station/api';
import type { Station } from '../station/station';
import type { Alignment, PlaceAnswer } from '../station/types';
import { nameOf } from '../station/station';
import type { RoughPlacement } from '../view/placing';

const far_m = 5; // of the operator's placement; what ends farther off is another one, and not kept
const far_deg = 25;

/** Throws the server's line against it. */
export async function register(station: Station, { a, b, at }: RoughPlacement, signal: AbortSignal): Promise<PlaceAnswer> {
  const [of_a, of_b] = [a, b].map((id) => encodeURIComponent(nameOf(station.sessions.get(id)!)));
  const answer = await askJson<PlaceAnswer>(`/api/v1/place?a=${of_a}&b=${of_b}`, { method: 'POST', body: { at }, signal });
  if (answer.recorded) await station.refreshAtlas();
  return answer;
}

/** The pair that was recorded. */
export function recordedOf(station: Station, { explanation }: PlaceAnswer): Alignment | undefined {
  const pair = [explanation.a, explanation.b].map(nameOf).sort().join();
  return [...station.alignments.values()].find(({ a, b }) => [a, b].map(nameOf).sort().join() === pair);
}

export function movedText({ moved_m, turned_deg, recorded }: PlaceAnswer): string {
  if (moved_m === null || turned_deg === null) return 'Not kept: it does not fit where it was laid.';
  const moved = `moved it by ${moved_m.toFixed(2)} m and ${turned_deg.toFixed(1)}°`;
  if (recorded) return `Registration ${moved}. It waits for you: confirm it or refuse it.`;
  if (moved_m > far_m || turned_deg > far_deg) return `Not kept: registration ${moved}, which is another placement than yours. Lay it nearer if it is right.`;
  return 'Not kept: it does not fit where it was laid.';
}
