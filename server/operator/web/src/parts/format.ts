// Figures for people.

export function count(value: number): string {
  return value.toLocaleString('en').replaceAll(',', '\u202f');
}

/** Short, for a column: 940, 12.4 k, 3.1 M. */
export function compact(value: number): string {
  if (value < 1000) return String(Math.round(value));
  return value < 1e6 ? `${(value / 1e3).toFixed(1)} k` : `${(value / 1e6).toFixed(1)} M`;
}

export function bytes(value: number): string {
  if (value < 1000) return `${Math.round(value)} B`;
  if (value < 1e6) return `${(value / 1e3).toFixed(value < 1e4 ? 1 : 0)} kB`;
  return value < 1e9 ? `${(value / 1e6).toFixed(1)} MB` : `${(value / 1e9).toFixed(2)} GB`;
}

export function duration(seconds: number): string {
  if (seconds < 10) return `${seconds.toFixed(1)} s`;
  if (seconds < 90) return `${Math.round(seconds)} s`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min`;
  return `${(seconds / 3600).toFixed(1)} h`;
}

export function metres(value: number): string {
  return value < 1000 ? `${Math.round(value)} m` : `${(value / 1000).toFixed(2)} km`;
}

export const wallClock_s = 1e9; // stamps beyond are seconds since 1970, below they count from a start of the robot's own

export const dayAndTime = (stamp_s: number) => new Date(stamp_s * 1000).toLocaleString('en-GB', { day: '2-digit', month: 'short', hour: '2-digit', minute: '2-digit' });

export const dayAndYear = (stamp_s: number) => new Date(stamp_s * 1000).toLocaleString('en-GB', { day: '2-digit', month: 'short', year: 'numeric' });

export const momentText = (stamp_s: number) =>
  new Date(stamp_s * 1000).toLocaleString('en-GB', { day: '2-digit', month: 'short', year: 'numeric', hour: '2-digit', minute: '2-digit', second: '2-digit' });

export const day = (at: Date) => at.toLocaleDateString('en-GB', { weekday: 'short', day: '2-digit', month: 'short', year: 'numeric' });
export const clock = (at: Date) => at.toLocaleTimeString('en-GB');

/** Never 0 % or 100 % of what is not. */
export function percent(share: number): string {
  if (share > 0 && share < 0.01) return '<\u202f1\u202f%';
  if (share < 1 && share > 0.99) return '>\u202f99\u202f%';
  return `${Math.round(100 * share)}\u202f%`;
}
