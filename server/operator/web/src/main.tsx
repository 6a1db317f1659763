// Puts the page together.

import './style/page.css';
import { render } from 'preact';
import { Actions } from './actions/actions';
import { App } from './app';
import type { Desk } from './context';
import { listenForKeys } from './panels/keys';
import { Station } from './station/station';
import { Player } from './time/player';
import { askForToken } from './token_dialog';
import { Ui } from './ui';
import { MineView } from './view/mine_view';
import { RobotColours } from './view/palette';

const panels_ms = 120; // between two drawings of the panels; the view draws with every frame

const station = new Station(askForToken);
const ui = new Ui();
const player = new Player(station, ui);
let view: MineView | null = null;
const desk: Desk = { station, ui, actions: new Actions(station), colours: new RobotColours(), player, view: () => view };
const host = document.getElementById('app')!;

/** What the server is asked for comes meanwhile. */
function mount(canvas: HTMLCanvasElement, layer: HTMLElement): void {
  view = new MineView(canvas, layer, desk, draw);
  Object.assign(window, { headframe: { shown: view.shown } }); // for the tests and the bench
}

function draw(): void {
  desk.colours.know(station.sessions.values());
  document.documentElement.dataset.theme = ui.isDark ? 'dark' : 'light';
  render(<App desk={desk} mount={mount} />, host);
}

/** What is looked at closely: selected, followed, or shown as it was at some time. */
function completePaths(): void {
  const { session, follow } = ui.now;
  const near = [session, follow].filter((id) => id !== null);
  station.completePaths(player.open && session === null ? station.sessions.keys() : near);
}

let due = 0;
function drawSoon(): void {
  due ||= window.setTimeout(() => {
    due = 0;
    view?.awaitsPoints() ? drawSoon() : draw();
  }, panels_ms);
}
station.onChange(() => {
  player.sync();
  completePaths();
  drawSoon();
});
player.onChange(() => {
  completePaths();
  draw();
});

let { measuring, measureOf } = ui.now;
ui.onChange(() => {
  player.sync();
  completePaths();
  view?.stage.show(ui.now.way);
  if (measuring && (!ui.now.measuring || measureOf !== ui.now.measureOf)) view?.measure.clear();
  ({ measuring, measureOf } = ui.now);
  draw();
});

station.start();
draw();
listenForKeys(desk);
