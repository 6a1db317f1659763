// What changed in the mine between sessions, as the page calls it. Pure.

import type { Change } from './types';

/** Colour, sign and word together: no colour has to be told apart. */
export const changeLooks = {
  excavated: { sign: '−', about: 'rock or what stood there is gone', dark: '#6cc3f2', light: '#0a6093' },
  filled: { sign: '+', about: 'something stands or lies there now', dark: '#f0b44c', light: '#855400' },
} as const;

/** Those that may have come after this day of the operator's calendar, YYYY-MM-DD; all for anything else. */
export function changesSince(changes: Change[], day: string): Change[] {
  const since_s = new Date(`${day}T00:00`).getTime() / 1000;
  return Number.isNaN(since_s) ? changes : changes.filter(({ newer }) => newer.stamp_s >= since_s);
}

/** What is gone or new: length, width and height. */
export const changeSize = ({ size_m }: Change) => `${size_m.map((metres) => metres.toFixed(1)).join(' × ')} m`;

/** The same change in every list that the server gives, while the sessions that tell of it stay the same. */
export const changeKey = ({ kind, alignment, p }: Change) => `${kind}-${alignment}-${p.map((metres) => metres.toFixed(1)).join('-')}`;
