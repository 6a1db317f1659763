// The page: a line at the top, robots left, the mine in the middle, what is known of it right.

import type { Desk } from './context';
import { wantsLook } from './station/pairs';
import { Alarm } from './panels/alarm';
import { ChangesPanel } from './panels/changes';
import { Header } from './panels/header';
import { LogPanel } from './panels/log';
import { MergesPanel } from './panels/merges';
import { NotesPanel } from './panels/notes';
import { RobotsPanel } from './panels/robots';
import { SessionsPanel } from './panels/sessions';
import { SurveyPanel } from './panels/survey';
import { ViewPane } from './panels/view_pane';
import type { Choices, Tab } from './ui';

const tabs: Record<Tab, string> = { merges: 'Merges', sessions: 'Sessions', log: 'Events', changes: 'Changes', notes: 'Notes' };
const order = Object.keys(tabs) as Tab[];

function Tabs({ desk }: { desk: Desk }) {
  const { ui, station } = desk;
  const unsure = [...station.alignments.values()].filter(wantsLook).length;
  const move = (event: KeyboardEvent) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const tab = order[(order.indexOf(ui.now.tab) + step + order.length) % order.length];
    ui.set({ tab });
    document.getElementById(`tab-${tab}`)?.focus();
  };
  const surveyed = station.sessions.get(ui.now.survey ?? -1);
  if (surveyed)
    return (
      <section class="panel side" aria-label="Survey">
        <div class="tab-panel">
          <SurveyPanel key={surveyed.id} desk={desk} session={surveyed} />
        </div>
      </section>
    );
  return (
    <section class="panel side" aria-label="What is known">
      <div class="tabs" role="tablist" onKeyDown={move}>
        {order.map((tab) => (
          <button key={tab} id={`tab-${tab}`} role="tab" aria-selected={ui.now.tab === tab} aria-controls="tab-panel" tabIndex={ui.now.tab === tab ? 0 : -1} onClick={() => ui.set({ tab })}>
            {tabs[tab]}
            {tab === 'merges' && unsure > 0 && (
              <span class="badge" title="pairs that want a look">
                {unsure}
              </span>
            )}
          </button>
        ))}
      </div>
      <div id="tab-panel" class="tab-panel" role="tabpanel" aria-labelledby={`tab-${ui.now.tab}`}>
        {ui.now.tab === 'merges' && <MergesPanel desk={desk} />}
        {ui.now.tab === 'sessions' && <SessionsPanel desk={desk} />}
        {ui.now.tab === 'log' && <LogPanel desk={desk} />}
        {ui.now.tab === 'changes' && <ChangesPanel desk={desk} />}
        {ui.now.tab === 'notes' && <NotesPanel desk={desk} />}
      </div>
    </section>
  );
}

/** On a phone the map has the page to itself, and one of these opens what lies over it. */
function SheetBar({ desk }: { desk: Desk }) {
  const { ui } = desk;
  const { sheet, tab } = ui.now;
  const entry = (name: string, pressed: boolean, open: Partial<Choices>) => (
    <button key={name} class="sheet-button" aria-pressed={pressed} onClick={() => ui.set(pressed ? { sheet: null } : open)}>
      {name}
    </button>
  );
  return (
    <nav class="sheet-bar" aria-label="What to show">
      {entry('Map', sheet === null, { sheet: null })}
      {entry('Robots', sheet === 'robots', { sheet: 'robots' })}
      {order.map((name) => entry(tabs[name], sheet === 'side' && tab === name, { sheet: 'side', tab: name, survey: null }))}
    </nav>
  );
}

export function App({ desk, mount }: { desk: Desk; mount: (canvas: HTMLCanvasElement, layer: HTMLElement) => void }) {
  return (
    <div class={desk.station.link === 'away' ? 'page page-away' : 'page'} data-sheet={desk.ui.now.sheet ?? 'none'}>
      <div class="head">
        <Header desk={desk} />
        <Alarm desk={desk} />
      </div>
      <RobotsPanel desk={desk} />
      <ViewPane desk={desk} mount={mount} />
      <Tabs desk={desk} />
      <SheetBar desk={desk} />
    </div>
  );
}
