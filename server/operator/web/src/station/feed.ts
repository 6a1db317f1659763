// The server's events over WebSocket, for as long as the page is open.

import type { StationEvent } from './types';

export type LinkState = 'connecting' | 'live' | 'away';

const shortestWait_ms = 400;
const longestWait_ms = 5000;

export interface FeedListener {
  /** Before each connection: settles once the server answers and the token is right; throws when it does not answer. */
  admit(): Promise<void>;
  event(event: StationEvent): void;
  link(state: LinkState): void;
}

/** Connects, and again whenever the link ends, after a wait that doubles. Each connection begins with a snapshot. */
export class Feed {
  private wait_ms = shortestWait_ms;

  constructor(private readonly listener: FeedListener) {}

  async open(): Promise<void> {
    try {
      await this.listener.admit();
      this.connect();
    } catch {
      this.again();
    }
  }

  private connect(): void {
    const url = `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/api/v1/events`;
    const socket = new WebSocket(url);
    socket.onmessage = (message) => {
      const event = JSON.parse(message.data) as StationEvent;
      if (event.type === 'snapshot') {
        this.wait_ms = shortestWait_ms;
        this.listener.link('live');
      }
      this.listener.event(event);
    };
    socket.onclose = () => this.again();
  }

  private again(): void {
    this.listener.link('away');
    setTimeout(() => void this.open(), this.wait_ms);
    this.wait_ms = Math.min(2 * this.wait_ms, longestWait_ms);
  }
}
