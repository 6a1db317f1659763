// Control points of a session: picked on the map, typed, pasted or dropped as a file; and how well they fit.

import { useEffect, useLayoutEffect, useState } from 'preact/hooks';
import { fitText, pointsOf, type Row, rowOf, rowsOf, transformOf } from '../actions/survey_text';
import type { Desk } from '../context';
import { Icon } from '../parts/icons';
import { ApiError } from '../station/api';
import type { Session, Survey, SurveyBody } from '../station/types';
import { matrixOf } from '../view/layout';
import type { Picked } from '../view/pick';

const columns = ['x', 'y', 'z'] as const;
const gridColumns = ['East', 'North', 'Height'] as const;
const empty: [string, string, string] = ['', '', ''];

/** A point of any session of the same map, in the session's own frame; a word why not. */
function inSession(desk: Desk, session: Session, { session: other, p_session }: Picked): [string, string, string] | string {
  const { placed } = desk.station;
  const [mine, theirs] = [placed.get(session.id), placed.get(other)];
  if (!mine || !theirs || mine.component !== theirs.component) return `That point lies in another map: pick one of the map of ${desk.station.titleOf(session)}.`;
  const p = p_session.clone().applyMatrix4(matrixOf(theirs.T_component_session)).applyMatrix4(matrixOf(mine.T_component_session).invert());
  return p.toArray().map((value) => value.toFixed(3)) as [string, string, string];
}

function freeName(rows: Row[]): string {
  const taken = new Set(rows.map(({ name }) => name));
  let at = rows.length + 1;
  while (taken.has(`P${at}`)) at++;
  return `P${at}`;
}

interface RowProps {
  row: Row;
  residual_m: number | undefined;
  suspect: boolean;
  change: (row: Row) => void;
  remove: () => void;
}

function PointRow({ row, residual_m, suspect, change, remove }: RowProps) {
  const cells = (of: 'session' | 'grid', words: readonly string[]) =>
    words.map((word, at) => (
      <input
        key={word}
        inputMode="decimal"
        placeholder={word}
        aria-label={`${word} of ${row.name}${of === 'session' ? ' on the map' : ' in the mine grid'}`}
        value={row[of][at]}
        onInput={(event) => change({ ...row, [of]: row[of].map((old, other) => (other === at ? event.currentTarget.value : old)) })}
      />
    ));
  return (
    <li class={suspect ? 'control control-suspect' : 'control'}>
      <input class="control-name" aria-label="Name of the point" value={row.name} onInput={(event) => change({ ...row, name: event.currentTarget.value })} />
      <span class="muted control-off">{residual_m === undefined ? '' : `off by ${(100 * residual_m).toFixed(1)} cm${suspect ? ', likely wrong' : ''}`}</span>
      <button type="button" class="button button-small button-icon" aria-label={`Remove ${row.name}`} title="Remove" onClick={remove}>
        <Icon name="close" />
      </button>
      <div class="control-cells">
        <span class="muted">map</span>
        {cells('session', columns)}
      </div>
      <div class="control-cells">
        <span class="muted">grid</span>
        {cells('grid', gridColumns)}
      </div>
    </li>
  );
}

export function SurveyPanel({ desk, session }: { desk: Desk; session: Session }) {
  const { station, ui } = desk;
  const before = station.surveys.find(({ session_id }) => session_id === session.id);
  const [rows, setRows] = useState<Row[]>(() => before?.points.map(rowOf) ?? []);
  const [text, setText] = useState('');
  const [picking, setPicking] = useState(false);
  const [fault, setFault] = useState<{ text: string; mayAccept: boolean }>({ text: '', mayAccept: false });
  const [done, setDone] = useState<Survey | undefined>(before);
  const title = station.titleOf(session);
  const wrong = (error: unknown) => setFault({ text: (error as Error).message, mayAccept: error instanceof ApiError && error.status === 403 });
  const change = (next: Row[]) => {
    setRows(next);
    setDone(undefined);
    setFault({ text: '', mayAccept: false });
  };

  useEffect(() => {
    const placed = rows.filter((row) => row.session.every((cell) => cell.trim() !== '' && Number.isFinite(Number(cell))));
    station.draft = placed.map((row) => ({ session: session.id, name: row.name, p_session: row.session.map(Number) as [number, number, number] }));
    station.changed();
  }, [rows]);
  // Before the next click: one that came in between would choose a robot.
  useLayoutEffect(() => {
    const take = (found: Picked | null) => {
      const place = found ? inSession(desk, session, found) : 'No point of a map is there: click nearer to a wall.';
      if (typeof place === 'string') return setFault({ text: place, mayAccept: false });
      change([...rows, { name: freeName(rows), session: place, grid: empty }]);
    };
    desk.view()?.give(picking ? take : null);
    return () => desk.view()?.give(null);
  }, [picking, rows]);
  const leave = () => {
    station.draft = [];
    station.changed();
  };
  useEffect(() => leave, []);

  const takeText = (given: string) => {
    try {
      const T = transformOf(given);
      if (T) return void send({ T_grid_session: T });
      change([...rows, ...rowsOf(given)]);
      setText('');
    } catch (error) {
      wrong(error);
    }
  };
  const send = async (body?: SurveyBody, accept = false) => {
    try {
      setFault({ text: '', mayAccept: false });
      const survey = await desk.actions.placeInGrid(session, body ?? { points: pointsOf(rows) }, before, accept);
      setPicking(false);
      setDone(survey);
    } catch (error) {
      wrong(error);
    }
  };
  const drop = (event: DragEvent) => {
    event.preventDefault();
    void event.dataTransfer?.files[0]?.text().then(takeText);
  };
  return (
    <article class="evidence survey" aria-label={`Survey of ${title}`} onDragOver={(event) => event.preventDefault()} onDrop={drop}>
      <button class="back" onClick={() => ui.set({ survey: null })}>
        <Icon name="back" /> Back
      </button>
      <h3>Survey of {title}</h3>
      <p class="muted">
        Control points tie this map to the mine grid. Three are needed, a fourth tells a blunder. Pick each on the map and give its place in the grid; or drop a CSV here: name, x, y, z of the
        session, east, north, height of the grid, in metres.
      </p>
      <div class="actions">
        <button class="button" aria-pressed={picking} onClick={() => setPicking(!picking)}>
          <Icon name="target" /> Pick on the map
        </button>
        <button class="button" onClick={() => change([...rows, { name: freeName(rows), session: empty, grid: empty }])}>
          <Icon name="plus" /> Point
        </button>
        <label class="button">
          CSV…
          <input class="unseen" type="file" accept=".csv,.txt,text/*" onChange={(event) => void event.currentTarget.files?.[0]?.text().then(takeText)} />
        </label>
      </div>
      {picking && (
        <p role="status" class="by-hand">
          Click the next control point on the map.
        </p>
      )}
      <ul class="controls">
        {rows.map((row, at) => (
          <PointRow
            key={at}
            row={row}
            residual_m={done?.points[at]?.residual_m}
            suspect={done?.suspect?.name === row.name}
            change={(next) => change(rows.map((old, other) => (other === at ? next : old)))}
            remove={() => change(rows.filter((_, other) => other !== at))}
          />
        ))}
      </ul>
      <details>
        <summary>Paste lines</summary>
        <label class="field">
          One point a line, or the 16 numbers of a known T_grid_session
          <textarea rows={5} spellcheck={false} value={text} onInput={(event) => setText(event.currentTarget.value)} placeholder={'S1  0.00  0.00 1.20   512345.60 7654321.10 -412.30\nS2 25.10  3.20 1.15   512361.90 7654340.00 -412.40'} />
        </label>
        <button class="button button-small" disabled={text.trim() === ''} onClick={() => takeText(text)}>
          Take over
        </button>
      </details>
      {fault.text && (
        <p class="fault" role="alert">
          {fault.text}
        </p>
      )}
      {done && <p class="outcome">{fitText(done) || 'Placed by a transform that was given.'}{done.suspect ? ` ${done.suspect.text}` : ''}</p>}
      <div class="actions">
        <button class="button button-main" disabled={rows.length === 0} onClick={() => void send()}>
          Place in the mine grid
        </button>
        {fault.mayAccept && (
          <button class="button button-danger" onClick={() => void send(undefined, true)}>
            Place all the same
          </button>
        )}
      </div>
    </article>
  );
}
