// A line at the lower edge that says what was done, with a button that takes it back. Read out by screen readers.

const stays_ms = 12_000;

const host = document.createElement('div');
host.className = 'toasts';
host.setAttribute('role', 'status');
host.setAttribute('aria-live', 'polite');
// Over an open dialog as well: those lie in the browser's top layer.
document.body.append(host);

export interface Offer {
  word: string;
  run: () => void;
}

export function toast(text: string, { bad = false, offer }: { bad?: boolean; offer?: Offer } = {}): () => void {
  const line = document.createElement('div');
  line.className = bad ? 'toast toast-bad' : 'toast';
  const words = document.createElement('span');
  words.textContent = text;
  line.append(words);
  const close = () => line.remove();
  if (offer) {
    const button = document.createElement('button');
    button.className = 'toast-offer';
    button.textContent = offer.word;
    button.onclick = () => {
      close();
      offer.run();
    };
    line.append(button);
  }
  host.append(line);
  while (host.children.length > 3) host.firstChild!.remove();
  let timer = setTimeout(close, stays_ms);
  line.onpointerenter = () => clearTimeout(timer);
  line.onpointerleave = () => (timer = setTimeout(close, stays_ms / 2));
  return close;
}

/** Runs it; a fault becomes a line. */
export async function told(work: () => Promise<void>): Promise<void> {
  try {
    await work();
  } catch (error) {
    toast((error as Error).message, { bad: true });
  }
}
