// What happened, newest first, as the event log shows it: the server's own log, and what this page alone knows.

export type Tone = 'plain' | 'good' | 'doubt' | 'bad' | 'operator';

export interface LogEntry {
  key: string;
  at: Date;
  tone: Tone;
  text: string;
  session?: number;
  alignment?: number;
  kind?: string;
}

/** As the server writes it. */
export interface ServerEntry {
  id: number;
  at_s: number;
  kind: string;
  text: string;
  session_id: number | null;
  alignment_id: number | null;
}

const most = 1000;
const tones: Record<string, Tone> = { merged: 'good', withdrawn: 'bad', held_back: 'doubt', unsure: 'doubt', provisional: 'doubt', left: 'doubt', jumped: 'doubt', operator: 'operator', note: 'operator' };
const seenKey = 'headframe.withdrawals-seen';

export class Log {
  entries: LogEntry[] = [];
  /** Merges that were withdrawn, the newest first, until the operator has seen them. */
  alarms: ServerEntry[] = [];
  private next = 1;
  private newest = 0;

  add(tone: Tone, text: string, about: { session?: number; alignment?: number } = {}): void {
    this.keep({ key: `page-${this.next++}`, at: new Date(), tone, text, ...about });
  }

  /** The server's, in their order; those that are known already are left out. */
  take(entries: ServerEntry[]): void {
    if ((entries.at(-1)?.id ?? this.newest) < this.newest) this.forget(); // another server, whose entries count anew
    const seen = Number(localStorage.getItem(seenKey) ?? 0);
    for (const entry of entries) {
      if (entry.id <= this.newest) continue;
      this.newest = entry.id;
      const about = { session: entry.session_id ?? undefined, alignment: entry.alignment_id ?? undefined };
      this.keep({ key: `server-${entry.id}`, at: new Date(1000 * entry.at_s), tone: tones[entry.kind] ?? 'plain', text: entry.text, kind: entry.kind, ...about });
      if (entry.kind === 'withdrawn' && entry.at_s > seen) this.alarms = [entry, ...this.alarms];
      // Merged again: nothing to be alarmed about.
      if (entry.kind === 'merged') this.alarms = this.alarms.filter(({ alignment_id }) => alignment_id !== entry.alignment_id);
    }
  }

  /** What came so far need not be shown again, on this page or after a reload. */
  seen(): void {
    if (this.alarms[0]) localStorage.setItem(seenKey, String(this.alarms[0].at_s));
    this.alarms = [];
  }

  private forget(): void {
    this.entries = [];
    this.alarms = [];
    this.newest = 0;
  }

  private keep(entry: LogEntry): void {
    this.entries = [entry, ...this.entries].sort((x, y) => Number(y.at) - Number(x.at)).slice(0, most);
  }
}
