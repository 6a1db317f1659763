// Files from the server. They are taken piece by piece into blobs, which a browser keeps on disk when they are large;
// a plain link could not show the operator's token.

import { ask } from '../station/api';

const piece_bytes = 16 << 20;

/** Throws when the server fails; an export that ends too early is an error, never a shorter file. */
export async function download(path: string, name: string, progress: (bytes: number) => void, signal?: AbortSignal): Promise<number> {
  const response = await ask(path, { signal });
  const reader = response.body!.getReader();
  const kept: Blob[] = [];
  let pieces: BlobPart[] = [];
  let pending = 0;
  let total = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    pieces.push(value);
    pending += value.length;
    total += value.length;
    progress(total);
    if (pending < piece_bytes) continue;
    kept.push(new Blob(pieces));
    pieces = [];
    pending = 0;
  }
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([...kept, ...pieces]));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
  return total;
}
