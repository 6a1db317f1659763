// What a pair of sessions comes to, for those who look at many. Pure.

import { percent } from '../parts/format';
import type { Alignment } from './types';

type Pair = Pick<Alignment, 'state' | 'decision'> & { evidence: Record<string, number | null> };

const convincing = 0.9;

/** Whole metres of path that a convincing pair waits for, since more path may show that it is a look-alike; 0: it
 * waits for nothing. */
export function awaitedOf({ state, decision, evidence }: Pair): number {
  const waits = decision === 'none' && ['candidate', 'provisional'].includes(state) && (evidence.probability ?? 0) >= convincing;
  return waits ? Math.ceil(evidence.awaited_m ?? 0) : 0;
}

/** The server can not tell alone: unsure, contradicted, or withdrawn after it had been merged. */
export const wantsLook = (pair: Pair) => ['none', 'placed'].includes(pair.decision) && ['candidate', 'verified', 'retracted'].includes(pair.state) && awaitedOf(pair) === 0;

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
    return `It fits, and more path may yet show that it is a look-alike: ${Math.ceil(awaited)} m of path are awaited. A wrong merge sends robots wrong transforms.`;
  return state !== 'published' && probability < doubtful ? `The evidence gives it a probability of ${percent(probability)} only. A wrong merge sends robots wrong transforms.` : '';
}
