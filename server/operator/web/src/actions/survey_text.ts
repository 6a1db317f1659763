// Control points as text: what a surveyor pastes, or drops as a file. Pure.

import type { SurveyPoint } from '../station/types';

/** As typed: a point that was picked on the map has no place in the grid yet. */
export interface Row {
  name: string;
  session: [string, string, string];
  grid: [string, string, string];
}

const figures = 6;

/** Of a file with semicolons or tabs the comma is the decimal sign, else it stands between cells, as blanks do. */
function cellsOf(line: string): string[] {
  const strict = /[;\t]/.test(line);
  const cells = strict ? line.split(/[;\t]/).map((cell) => cell.trim().replace(',', '.')) : line.split(/\s*,\s*|\s+/);
  while (cells.length > figures + 1 && cells.at(-1) === '') cells.pop();
  return cells;
}

const isNumber = (cell: string) => cell !== '' && Number.isFinite(Number(cell));

/** name, x, y, z in the session's frame, east, north, height in the grid; a first line of titles, empty lines and those that
 * begin with # are left out. Throws with the line that is wrong. */
export function rowsOf(text: string): Row[] {
  const rows: Row[] = [];
  text.split(/\r?\n/).forEach((full, at) => {
    const line = full.trim();
    if (line === '' || line.startsWith('#')) return;
    const [name, ...values] = cellsOf(line);
    if (rows.length === 0 && values.length > 0 && !values.some(isNumber)) return; // titles
    const wrong = values.find((value) => !isNumber(value));
    if (values.length !== figures) throw new Error(`Line ${at + 1}: a name and ${figures} numbers are needed, ${values.length} ${values.length === 1 ? 'cell stands' : 'cells stand'} after the name.`);
    if (wrong !== undefined) throw new Error(`Line ${at + 1}: “${wrong}” is no number.`);
    rows.push({ name, session: values.slice(0, 3) as Row['session'], grid: values.slice(3) as Row['grid'] });
  });
  return rows;
}

/** The 16 numbers of T_grid_session, row by row; null: the text is something else. */
export function transformOf(text: string): number[] | null {
  const cells = text.trim().split(/[\s,;]+/);
  return cells.length === 16 && cells.every(isNumber) ? cells.map(Number) : null;
}

/** Throws with what is missing. */
export function pointsOf(rows: Row[]): SurveyPoint[] {
  const points = rows.map(({ name, session, grid }, at) => {
    const called = name.trim() || `point ${at + 1}`;
    const wrong = [...session, ...grid].findIndex((cell) => !isNumber(cell.trim().replace(',', '.')));
    if (wrong >= 0) throw new Error(`${called}: ${['x', 'y', 'z', 'east', 'north', 'height'][wrong]} is missing or no number.`);
    const [p_session, p_grid] = [session, grid].map((cells) => cells.map((cell) => Number(cell.trim().replace(',', '.'))));
    return { name: called, p_session, p_grid };
  });
  if (points.length < 3) throw new Error(`Three control points are needed; there ${points.length === 1 ? 'is 1' : `are ${points.length}`}. A fourth tells a blunder.`);
  return points;
}

export const rowOf = ({ name, p_session, p_grid }: SurveyPoint): Row => ({ name, session: p_session.map(String) as Row['session'], grid: p_grid.map(String) as Row['grid'] });

const cm = (metres: number) => `${(100 * metres).toFixed(1)} cm`;

/** How well the points fit; empty without points. */
export function fitText({ rms_m, points }: { rms_m: number | null; points: { name: string; residual_m: number }[] }): string {
  if (rms_m === null) return '';
  const worst = points.reduce((x, y) => (y.residual_m > x.residual_m ? y : x));
  return `The points fit within ${cm(rms_m)} (rms); the worst is ${worst.name}, off by ${cm(worst.residual_m)}.`;
}
