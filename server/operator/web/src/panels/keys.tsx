// The keys of the page.

import { ask } from '../parts/dialog';
import type { Desk } from '../context';

const keys: [string, string][] = [
  ['← → ↑ ↓', 'move the map'],
  ['+ −', 'zoom'],
  ['F', 'show all'],
  ['T', 'top view or free view'],
  ['C', 'colour by robot, height, age'],
  ['R', 'roof on or off'],
  ['G', 'lines of coordinates'],
  ['M', 'measure; Enter takes the point under the cross, Backspace the last one back'],
  ['[ ] ← → ↑ ↓', 'while a map is placed: turn and move it, with Shift less; Page up and down lift it, Enter registers'],
  ['P', 'play, or pause'],
  ['D', 'changes of the mine'],
  ['1 2 3 4 5', 'merges, sessions, events, changes, notes'],
  ['Esc', 'let go of what is selected'],
  ['?', 'this list'],
];

export function showKeys(): Promise<boolean> {
  return ask({
    title: 'Keys',
    body: (
      <dl class="keys">
        {keys.map(([key, what]) => (
          <div key={key}>
            <dt>
              <kbd>{key}</kbd>
            </dt>
            <dd>{what}</dd>
          </div>
        ))}
      </dl>
    ),
  });
}

const arrows: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const step = 0.12;

/** Keys work wherever nothing else wants them: not in fields and dialogs, and not with Ctrl, Alt or Meta. */
export function listenForKeys(desk: Desk): void {
  addEventListener('keydown', (event) => {
    const at = event.target as HTMLElement;
    if (event.ctrlKey || event.altKey || event.metaKey || at.closest('dialog, input, textarea, select')) return;
    if (act(desk, event.key, at, event.shiftKey)) event.preventDefault();
  });
}

const degree = Math.PI / 180;
const turns: Record<string, number> = { '[': 5, ']': -5, '{': 1, '}': -1 };
const lifts_m: Record<string, number> = { PageUp: 0.5, PageDown: -0.5 };
const placeStep_m = 1;

/** Of a map that is being placed. */
function place({ ui, view }: Desk, key: string, onMap: boolean, fine: boolean): boolean {
  const placing = view()?.placing;
  if (key in turns) placing?.turn(degree * turns[key]);
  else if (onMap && key in lifts_m) placing?.lift(lifts_m[key]);
  else if (onMap && key in arrows) placing?.move(...(arrows[key].map((way) => way * (fine ? 0.1 : 1) * placeStep_m) as [number, number]));
  else if (onMap && key === 'Enter') document.getElementById('register')?.click();
  else if (key === 'Escape') ui.set({ placing: null, placed: null });
  else return false;
  return true;
}

function act(desk: Desk, key: string, at: HTMLElement, fine: boolean): boolean {
  const { ui } = desk;
  const view = desk.view();
  const onMap = at.tagName === 'CANVAS' || at === document.body;
  if (ui.now.placing && place(desk, key, onMap, fine)) return true;
  if (onMap && key in arrows) {
    const [right, up] = arrows[key];
    if (ui.now.follow !== null) ui.set({ follow: null });
    view?.stage.pan(step * right, step * up);
    return true;
  }
  if (onMap && key === 'Enter' && (ui.now.measuring || view?.giving)) {
    view?.takePoint();
    return true;
  }
  switch (key) {
    case '+':
    case '=':
      view?.stage.zoom(1.25);
      return true;
    case '-':
      view?.stage.zoom(0.8);
      return true;
    case 'f':
      view?.frameAll();
      return true;
    case 't':
      ui.set({ way: ui.now.way === 'top' ? 'free' : 'top' });
      return true;
    case 'c':
      ui.set({ colourBy: ({ robot: 'height', height: 'age', age: 'robot' } as const)[ui.now.colourBy] });
      return true;
    case 'r':
      ui.set({ roof_m: ui.now.roof_m === null ? 1 : null });
      return true;
    case 'g':
      ui.set({ grid: !ui.now.grid });
      return true;
    case 'd':
      ui.set({ changes: !ui.now.changes });
      return true;
    case 'Backspace':
      if (!ui.now.measuring) return false;
      view?.measure.back();
      ui.set({});
      return true;
    case 'p':
      desk.player.play(!desk.player.playing);
      return true;
    case 'm':
      ui.set({ measuring: !ui.now.measuring });
      return true;
    case '1':
    case '2':
    case '3':
    case '4':
    case '5':
      ui.set({ tab: (['merges', 'sessions', 'log', 'changes', 'notes'] as const)[Number(key) - 1] });
      return true;
    case 'Escape':
      ui.set(ui.now.measuring ? { measuring: false } : ui.now.follow !== null ? { follow: null } : { session: null, alignment: null, survey: null, sheet: null, change: null });
      return true;
    case '?':
      void showKeys();
      return true;
  }
  return false;
}
