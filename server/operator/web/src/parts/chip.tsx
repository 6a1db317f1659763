// A verdict: colour, glyph and word together.

import type { State } from '../station/types';
import { verdicts } from '../view/palette';

export function Chip({ state, isDark }: { state: State; isDark: boolean }) {
  const look = verdicts[state];
  return (
    <span class="chip" style={{ '--mark': isDark ? look.dark : look.light }}>
      <span aria-hidden="true">{look.glyph}</span>
      {look.word}
    </span>
  );
}
