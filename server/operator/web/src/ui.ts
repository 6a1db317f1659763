// What the operator has chosen to look at. Theme and panels only; nothing of the server.

import type { Clip } from './view/clip';
import type { ColourBy } from './view/cloud_material';
import type { PlaceAnswer } from './station/types';
import type { MeasureOf } from './view/measure';
import type { PlacingOf } from './view/placing';
import type { Way } from './view/stage';

export type Tab = 'merges' | 'sessions' | 'log' | 'changes' | 'notes';
/** What lies over the map where there is room for one thing only. */
export type Sheet = 'robots' | 'side' | 'tools';
export type Theme = 'auto' | 'dark' | 'light';

const themeKey = 'headframe.theme';
const prefersDark = matchMedia('(prefers-color-scheme: dark)');

export interface Choices {
  session: number | null;
  alignment: number | null;
  tab: Tab;
  theme: Theme;
  way: Way;
  colourBy: ColourBy;
  /** Metres over the robot's path above which nothing is drawn; null: the roof stays on. */
  roof_m: number | null;
  /** Heights between which points are drawn; null: all. */
  slice_m: [number, number] | null;
  /** The session whose robot the view stays on. */
  follow: number | null;
  measuring: boolean;
  measureOf: MeasureOf;
  sectionWidth_m: number;
  /** A session that is laid on another map by hand. */
  placing: PlacingOf | null;
  /** What came of it, when it was not kept. */
  placed: PlaceAnswer | null;
  /** Outside of it nothing is shown. */
  clip: Clip | null;
  grid: boolean;
  /** Whether changes of the mine are drawn, those alone that may have come after this day (YYYY-MM-DD; empty: all), and the one that is selected. */
  changes: boolean;
  changesFrom: string;
  change: string | null;
  /** The session whose survey is worked on. */
  survey: number | null;
  sheet: Sheet | null;
  showRejected: boolean;
  /** Of the events those alone that operators did. */
  doneOnly: boolean;
}

export class Ui {
  now: Choices = {
    session: null,
    alignment: null,
    tab: 'merges',
    theme: (localStorage.getItem(themeKey) as Theme | null) ?? 'auto',
    way: 'top',
    colourBy: 'robot',
    roof_m: 1,
    slice_m: null,
    follow: null,
    measuring: false,
    measureOf: 'distance',
    sectionWidth_m: 2,
    placing: null,
    placed: null,
    clip: null,
    grid: true,
    changes: true,
    changesFrom: '',
    change: null,
    survey: null,
    sheet: null,
    showRejected: false,
    doneOnly: false,
  };
  private readonly listeners: (() => void)[] = [];

  constructor() {
    prefersDark.addEventListener('change', () => this.set({}));
  }

  get isDark(): boolean {
    return this.now.theme === 'dark' || (this.now.theme === 'auto' && prefersDark.matches);
  }

  set(change: Partial<Choices>): void {
    this.now = { ...this.now, ...change, ...alone(change) };
    if (change.theme) localStorage.setItem(themeKey, change.theme);
    for (const listener of this.listeners) listener();
  }

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }
}

/** Who places a map does nothing else with the pointer, and looks from above. */
function alone({ placing, measuring }: Partial<Choices>): Partial<Choices> {
  if (placing) return { measuring: false, follow: null, survey: null, way: 'top' };
  return measuring ? { placing: null, placed: null } : {};
}
