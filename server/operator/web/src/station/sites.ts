// The mine that is looked at, where several share the server; this browser remembers it.

import type { Session } from './types';

const key = 'headframe.site';
const siteOf = (session: Session) => session.site ?? '';

export class SiteChoice {
  private chosen = localStorage.getItem(key);

  /** By name; the empty one of sessions that belong to none. */
  names(all: Map<number, Session>): string[] {
    return [...new Set([...all.values()].map(siteOf))].sort();
  }

  /** Null: all, also where nothing is left at the one that was chosen. */
  of(all: Map<number, Session>): string | null {
    return this.chosen !== null && this.names(all).includes(this.chosen) ? this.chosen : null;
  }

  choose(site: string | null): void {
    this.chosen = site;
    if (site === null) localStorage.removeItem(key);
    else localStorage.setItem(key, site);
  }

  shown(all: Map<number, Session>): Map<number, Session> {
    const site = this.of(all);
    return site === null ? all : new Map([...all].filter(([, session]) => siteOf(session) === site));
  }
}
