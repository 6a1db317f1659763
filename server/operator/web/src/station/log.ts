// What happened, newest first, as the event log shows it.

export type Tone = 'plain' | 'good' | 'doubt' | 'bad' | 'operator';

export interface LogEntry {
  id: number;
  at: Date;
  tone: Tone;
  text: string;
  session?: number;
  alignment?: number;
}

const most = 400;

export class Log {
  entries: LogEntry[] = [];
  private next = 1;

  add(tone: Tone, text: string, about: { session?: number; alignment?: number } = {}): void {
    this.entries = [{ id: this.next++, at: new Date(), tone, text, ...about }, ...this.entries].slice(0, most);
  }
}
