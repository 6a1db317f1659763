// A line at the lower edge that says what was done, with a button that takes it back. Read out by screen readers.

const stays_ms = 12_000;
const offerStays_ms = 60_000; // what can be taken back leaves time to read, look at the map and think

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
  const lasts_ms = offer ? offerStays_ms : stays_ms;
  let timer = setTimeout(close, lasts_ms);
  const hold = () => clearTimeout(timer);
  const letGo = () => {
    hold();
    timer = setTimeout(close, lasts_ms / 2);
  };
  for (const reached of ['pointerenter', 'focusin']) line.addEventListener(reached, hold);
  for (const left of ['pointerleave', 'focusout']) line.addEventListener(left, letGo);
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
