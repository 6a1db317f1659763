// A verdict: colour, glyph and word together.

import type { Alignment } from '../station/types';
import { lookOf } from '../view/palette';

export function Chip({ alignment, isDark }: { alignment: Alignment; isDark: boolean }) {
  const look = lookOf(alignment);
  return (
    <span class="chip" style={{ '--mark': isDark ? look.dark : look.light }}>
      <span aria-hidden="true">{look.glyph}</span>
      {look.word}
    </span>
  );
}
