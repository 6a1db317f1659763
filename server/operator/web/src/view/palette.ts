// Colours that mean something. Robots: after Okabe and Ito, told apart with any colour vision; beyond eight they come
// again, lighter, and names always stand beside them. Verdicts have a glyph and a dash of their own as well.

import { awaitedOf } from '../station/pairs';
import type { Alignment, SessionName, State } from '../station/types';

const dark = ['#e8a33d', '#58b6ea', '#2fb98c', '#d98bb5', '#efe06a', '#e8703a', '#8f9df5', '#a8d672'];
const light = ['#b87500', '#0b7cb8', '#00795a', '#a8487d', '#857500', '#b84a00', '#4453c4', '#4f7d12'];

export function mixed(colour: string, other: string, share: number): string {
  const channels = [1, 3, 5].map((at) => {
    const [x, y] = [colour, other].map((text) => parseInt(text.slice(at, at + 2), 16));
    return Math.round(x + (y - x) * share).toString(16).padStart(2, '0');
  });
  return `#${channels.join('')}`;
}

const runs = 4; // sessions of one robot that are told apart; further ones begin anew

/** Robots get theirs in the order of their first sessions, so that every page shows the same ones; their later sessions
 * are the same hue, paler. */
export class RobotColours {
  private readonly sessions = new Map<string, string[]>(); // by robot, in their order

  know(sessions: Iterable<SessionName & { id: number }>): void {
    for (const name of [...sessions].sort((x, y) => x.id - y.id)) this.runOf(name);
  }

  of(name: SessionName, isDark: boolean): string {
    const run = this.runOf(name) % runs;
    const index = [...this.sessions.keys()].indexOf(name.robot);
    const base = (isDark ? dark : light)[index % dark.length];
    const round = Math.floor(index / dark.length);
    const bright = round === 0 ? base : mixed(base, isDark ? '#ffffff' : '#000000', Math.min(0.18 * round, 0.55));
    return run === 0 ? bright : mixed(bright, isDark ? '#a8b0b8' : '#5a626a', 0.22 * run);
  }

  /** How many sessions of its robot were there before it. */
  private runOf({ robot, session }: SessionName): number {
    const known = this.sessions.get(robot) ?? [];
    this.sessions.set(robot, known);
    const at = known.indexOf(session);
    return at < 0 ? known.push(session) - 1 : at;
  }
}

export interface Look {
  word: string;
  glyph: string;
  dark: string;
  light: string;
  dash: [number, number] | null; // metres drawn, metres left out
}

export const verdicts: Record<State, Look> = {
  published: { word: 'merged', glyph: '✓', dark: '#3ecf9a', light: '#006a4e', dash: null },
  verified: { word: 'held back', glyph: '◆', dark: '#6cc3f2', light: '#0a6093', dash: [3, 1] },
  provisional: { word: 'provisional', glyph: '…', dark: '#b9a6f2', light: '#5b3fa8', dash: [4, 0.8] },
  candidate: { word: 'unsure', glyph: '?', dark: '#f0b44c', light: '#855400', dash: [1.6, 1.6] },
  retracted: { word: 'withdrawn', glyph: '↺', dark: '#f08c5a', light: '#9e4000', dash: [2.4, 1] },
  rejected: { word: 'no match', glyph: '✕', dark: '#9aa3af', light: '#57606b', dash: [0.6, 1.4] },
};

/** What became of it, in a word: who took it back matters, and so does what it waits for. */
export function lookOf(pair: Pick<Alignment, 'state' | 'decision' | 'evidence'>): Look {
  const { state, decision } = pair;
  const awaited_m = awaitedOf(pair);
  if (awaited_m > 0) return { ...verdicts.provisional, word: `waits for ${awaited_m} m of path` };
  if (state === 'published' || ['none', 'confirmed', 'placed'].includes(decision)) return verdicts[state];
  return { ...verdicts[decision === 'refused' ? 'rejected' : 'retracted'], word: decision === 'refused' ? 'refused' : 'taken apart' };
}

/** Cividis, thinned: even steps of lightness, the same to all eyes. */
export const ramp = ['#1b3a6b', '#434e6c', '#666970', '#8b8679', '#b3a772', '#dfcb5d', '#fdea45'];
