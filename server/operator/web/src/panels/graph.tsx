// The merge graph: sessions, and what is known between them.

import { useMemo } from 'preact/hooks';
import type { Desk } from '../context';
import { lookOf } from '../view/palette';
import { bend, graphLayout } from './graph_layout';

const width = 340;
const height = 190;
const margin = { x: 46, y: 22 };
const namedUpTo = 14; // with more the names would lie over each other; each node still tells its own

function press(work: () => void) {
  return (event: KeyboardEvent) => {
    if (event.key !== 'Enter' && event.key !== ' ') return;
    event.preventDefault();
    work();
  };
}

export function MergeGraph({ desk }: { desk: Desk }) {
  const { station, ui, colours } = desk;
  const sessions = [...station.sessions.values()];
  const alignments = [...station.alignments.values()].filter(({ state, id }) => state !== 'rejected' || ui.now.showRejected || id === ui.now.alignment);
  const index = new Map(sessions.map(({ id }, at) => [id, at]));
  const ends = alignments.map(({ a, b }) => [a, b].map((name) => index.get(station.idOf(name) ?? -1)) as [number | undefined, number | undefined]);
  const links = ends.filter((pair): pair is [number, number] => pair[0] !== undefined && pair[1] !== undefined);
  const shape = `${sessions.map(({ id }) => id).join()} ${links.join(' ')}`;
  const places = useMemo(() => graphLayout(sessions.length, links), [shape]).map(({ x, y }) => ({
    x: margin.x + x * (width - 2 * margin.x),
    y: margin.y + y * (height - 2 * margin.y),
  }));
  if (sessions.length < 2) return null;
  const radius = sessions.length > namedUpTo ? 6 : 9;
  return (
    <svg class="graph" viewBox={`0 0 ${width} ${height}`} role="group" aria-label="Merge graph: sessions and what joins them">
      {alignments.map((alignment, at) => {
        const [i, j] = ends[at];
        if (i === undefined || j === undefined) return null;
        const [p, q] = [places[i], places[j]];
        const look = lookOf(alignment);
        const middle = bend(p, q, places.filter((_, other) => other !== i && other !== j), radius + 8);
        // A quadratic curve passes half as far beside the line as its control point.
        const curve = `M${p.x} ${p.y}Q${2 * middle.x - (p.x + q.x) / 2} ${2 * middle.y - (p.y + q.y) / 2} ${q.x} ${q.y}`;
        const open = () => ui.set({ alignment: alignment.id, session: null });
        const words = `${station.titleOfName(alignment.a)} and ${station.titleOfName(alignment.b)}: ${look.word}`;
        return (
          <g
            key={alignment.id}
            class={ui.now.alignment === alignment.id ? 'graph-edge graph-open' : 'graph-edge'}
            style={{ '--mark': ui.isDark ? look.dark : look.light }}
            role="button"
            tabIndex={0}
            aria-label={words}
            onClick={open}
            onKeyDown={press(open)}
          >
            <title>{words}</title>
            <path class="graph-reach" d={curve} />
            <path class="graph-line" d={curve} stroke-dasharray={look.dash ? look.dash.map((m) => 2.4 * m).join(' ') : undefined} />
            <g transform={`translate(${middle.x} ${middle.y})`}>
              <circle class="graph-badge" r="7" />
              <text class="graph-glyph" dy="3.2">
                {look.glyph}
              </text>
            </g>
          </g>
        );
      })}
      {sessions.map((session, at) => {
        const open = () => {
          ui.set({ session: session.id, alignment: null });
          desk.view()?.look(session.id);
        };
        const { x, y } = places[at];
        return (
          <g
            key={session.id}
            class={ui.now.session === session.id ? 'graph-node graph-open' : 'graph-node'}
            style={{ '--mark': colours.of(session, ui.isDark) }}
            transform={`translate(${x} ${y})`}
            role="button"
            tabIndex={0}
            aria-label={`${station.titleOf(session)}, ${session.connected ? 'connected' : 'away'}`}
            onClick={open}
            onKeyDown={press(open)}
          >
            <title>{station.titleOf(session)}</title>
            <circle r={radius} class={session.connected ? '' : 'away'} />
            {sessions.length <= namedUpTo && (
              <text dy={y > height - 2 * margin.y ? -radius - 4 : radius + 12}>{station.titleOf(session)}</text>
            )}
          </g>
        );
      })}
    </svg>
  );
}
