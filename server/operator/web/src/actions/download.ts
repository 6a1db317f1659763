// Files from the server. They are taken piece by piece into blobs, which a browser keeps on disk when they are large;
// a plain link could not show the operator's token.

import { ask } from '../station/api';

const piece_bytes = 16 << 20;

export interface Progress {
  received_bytes: number;
  /** null: the server does not know it ahead. */
  total_bytes: number | null;
}

/** How many bytes it was. Throws when the server fails; an export that ends too early is an error, never a shorter file. */
export async function download(path: string, name: string, progress: (at: Progress) => void, signal: AbortSignal): Promise<number> {
  const response = await ask(path, { signal });
  const length = response.headers.get('Content-Length');
  const total_bytes = length === null ? null : Number(length);
  const reader = response.body!.getReader();
  const kept: Blob[] = [];
  let pieces: BlobPart[] = [];
  let pending_bytes = 0;
  let received_bytes = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    pieces.push(value);
    pending_bytes += value.length;
    received_bytes += value.length;
    progress({ received_bytes, total_bytes });
    if (pending_bytes < piece_bytes) continue;
    kept.push(new Blob(pieces));
    pieces = [];
    pending_bytes = 0;
  }
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([...kept, ...pieces]));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
  return received_bytes;
}
