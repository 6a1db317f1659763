// What a pair of sessions comes to, for those who look at many. Pure.

import { percent } from '../parts/format';
import type { Alignment } from './types';

type Pair = Pick<Alignment, 'state' | 'decision'> & { evidence: Record<string, number | null> };

/** The server can not tell alone: unsure, contradicted, or withdrawn after it had been merged. */
export const wantsLook = ({ state, decision }: Pick<Alignment, 'state' | 'decision'>) => decision === 'none' && ['candidate', 'verified', 'retracted'].includes(state);

/** What the figure beside a verdict says: of a pair that others contradict, or that an operator refused, its own evidence alone. */
export function sureness({ state, decision, evidence }: Pair): string {
  const figure = percent(evidence.probability ?? 0);
  const stands = state === 'published' || (['candidate', 'provisional'].includes(state) && decision === 'none');
  return stands ? `${figure} sure` : `${figure} by the pair alone`;
}

const doubtful = 0.5;

/** What speaks against confirming it; empty: nothing. */
export function doubtOf({ state, evidence }: Pair): string {
  if (state === 'verified') return 'Other sessions contradict this pair: it is most likely a look-alike. A wrong merge sends robots wrong transforms.';
  const probability = evidence.probability ?? 0;
  const awaited = evidence.awaited_m ?? 0;
  if (state !== 'published' && probability >= doubtful && awaited > 0)
    return `It fits, and robots that still drive may yet show that it is a look-alike: ${Math.ceil(awaited)} m of path are awaited. A wrong merge sends robots wrong transforms.`;
  return state !== 'published' && probability < doubtful ? `The evidence gives it a probability of ${percent(probability)} only. A wrong merge sends robots wrong transforms.` : '';
}
