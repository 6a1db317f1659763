// What speaks for and against a placement by hand that was not kept.

import { movedText } from '../actions/place';
import type { Desk } from '../context';
import { Icon } from '../parts/icons';
import type { PlaceAnswer } from '../station/types';
import { Measured, Outcome } from './evidence';

export function NotKept({ desk, answer }: { desk: Desk; answer: PlaceAnswer }) {
  const { a, b } = answer.explanation;
  const names = [a, b].map((name) => desk.station.titleOfName(name)).join(' and ');
  return (
    <article class="evidence" aria-label={`Not kept: ${names}`}>
      <button class="back" onClick={() => desk.ui.set({ placed: null })}>
        <Icon name="back" /> All pairs
      </button>
      <h3>{names}, where they were laid</h3>
      <p>{movedText(answer)}</p>
      <Outcome desk={desk} explanation={answer.explanation} />
      <Measured explanation={answer.explanation} />
    </article>
  );
}
