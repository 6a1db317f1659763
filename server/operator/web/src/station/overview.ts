// The first look at the station: one answer, which index.html has asked for before any script of the page was there.

import { keyframesOf } from './api';
import { filled } from './thin';
import type { Keyframe, StationEvent } from './types';

interface Early {
  /** What the points of the overview are: of each session so many at this level of detail, or all if there are fewer. */
  level: number;
  points: number;
  /** Not answered with 200: nobody has signed in yet; null: the server did not answer. */
  overview: Promise<Response | null>;
}

declare global {
  interface Window {
    early: Early;
  }
}

export const early = window.early;

export interface OverviewReader {
  snapshot(event: StationEvent & { type: 'snapshot' }): void;
  /** thin: stand-ins are in the path. */
  session(id: number, path: Keyframe[], points: ArrayBuffer, thin: boolean): void;
}

/** Tells what comes as it comes, as far as it comes: a server that breaks off is asked in other ways. */
export async function readOverview(reader: OverviewReader): Promise<void> {
  const response = await early.overview;
  if (!response?.ok || !response.body) return;
  const parts = partsOf(response.body);
  const text = async () => new TextDecoder().decode((await parts.next()).value!);
  try {
    const snapshot = JSON.parse(await text());
    reader.snapshot(snapshot);
    for (const { id } of snapshot.sessions.sessions) {
      const kept = keyframesOf(JSON.parse(await text()));
      const path = filled(kept);
      reader.session(id, path, (await parts.next()).value!.buffer, path.length > kept.length);
    }
  } catch {
    // the rest is missing
  }
}

/** Each part comes after its length (u32, little-endian). */
async function* partsOf(body: ReadableStream<Uint8Array>): AsyncGenerator<Uint8Array<ArrayBuffer>, undefined> {
  const reader = body.getReader();
  let held = new Uint8Array(0);
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    const longer = new Uint8Array(held.length + value.length);
    longer.set(held);
    longer.set(value, held.length);
    held = longer;
    for (;;) {
      const end = held.length < 4 ? Infinity : 4 + new DataView(held.buffer, held.byteOffset).getUint32(0, true);
      if (held.length < end) break;
      yield held.slice(4, end);
      held = held.subarray(end);
    }
  }
}
