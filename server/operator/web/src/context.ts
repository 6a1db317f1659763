// What every panel works with.

import type { Actions } from './actions/actions';
import type { Station } from './station/station';
import type { Player } from './time/player';
import type { Ui } from './ui';
import type { MineView } from './view/mine_view';
import type { RobotColours } from './view/palette';

export interface Desk {
  station: Station;
  ui: Ui;
  actions: Actions;
  colours: RobotColours;
  player: Player;
  view: () => MineView | null;
}
