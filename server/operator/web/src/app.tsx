// The page: a line at the top, robots left, the mine in the middle, what is known of it right.

import type { Desk } from './context';
import { Header } from './panels/header';
import { LogPanel } from './panels/log';
import { MergesPanel } from './panels/merges';
import { RobotsPanel } from './panels/robots';
import { SessionsPanel } from './panels/sessions';
import { ViewPane } from './panels/view_pane';
import type { Tab } from './ui';

const tabs: Record<Tab, string> = { merges: 'Merges', sessions: 'Sessions', log: 'Events' };
const order = Object.keys(tabs) as Tab[];

function Tabs({ desk }: { desk: Desk }) {
  const { ui, station } = desk;
  const unsure = [...station.alignments.values()].filter(({ state, decision }) => state === 'candidate' && decision === 'none').length;
  const move = (event: KeyboardEvent) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const tab = order[(order.indexOf(ui.now.tab) + step + order.length) % order.length];
    ui.set({ tab });
    document.getElementById(`tab-${tab}`)?.focus();
  };
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
      </div>
    </section>
  );
}

export function App({ desk, mount }: { desk: Desk; mount: (canvas: HTMLCanvasElement, layer: HTMLElement) => void }) {
  return (
    <div class={desk.station.link === 'away' ? 'page page-away' : 'page'}>
      <Header desk={desk} />
      <RobotsPanel desk={desk} />
      <ViewPane desk={desk} mount={mount} />
      <Tabs desk={desk} />
    </div>
  );
}
