// Where the pointer is, in the map's frame and in the mine's grid; a click holds a point, so that it can be copied.

import type { Transform } from '../station/types';
import { toast, told } from '../parts/toast';
import { moved } from './grid';

export interface Spot {
  /** Of the map that is there: "map of a". */
  map: string;
  p_component: [number, number, number | null]; // m; null: how high is not known
  T_grid_component: Transform | null;
}

const figure = (value: number) => value.toFixed(2).replace('-', '−');

/** "x 1.00 y 2.00 z 3.00 m" of the map's frame, and east, north, height of the mine's grid where it is surveyed. */
export function spotLines({ map, p_component: [x, y, z], T_grid_component }: Spot): string[] {
  const height = z === null ? '' : ` z ${figure(z)}`;
  const lines = [`x ${figure(x)} y ${figure(y)}${height} m in the frame of the ${map}`];
  if (T_grid_component) {
    const [e, n, h] = moved(T_grid_component, x, y, z ?? 0);
    lines.push(`E ${figure(e)} N ${figure(n)}${z === null ? '' : ` H ${figure(h)}`} m in the mine grid`);
  }
  return lines;
}

/** For another program: numbers, separated by tabs; the mine's grid where it is known. */
export function copied({ p_component: [x, y, z], T_grid_component }: Spot): string {
  const place = T_grid_component ? moved(T_grid_component, x, y, z ?? 0) : [x, y, z ?? 0];
  return (z === null ? place.slice(0, 2) : place).map((value) => value.toFixed(3)).join('\t');
}

export class Cursor {
  private readonly host = document.createElement('div');
  private readonly words = document.createElement('output');
  private readonly button = document.createElement('button');
  private held: Spot | null = null;

  constructor(layer: HTMLElement) {
    this.host.className = 'readout';
    this.host.hidden = true;
    this.button.className = 'button button-small';
    this.button.textContent = 'Copy';
    this.button.onclick = () =>
      void told(async () => {
        await navigator.clipboard.writeText(copied(this.held!));
        toast('The coordinates were copied.');
      });
    this.host.append(this.words, this.button);
    layer.after(this.host);
  }

  get holds(): boolean {
    return this.held !== null;
  }

  /** null: the pointer is over nothing. */
  show(spot: Spot | null): void {
    if (!this.held) this.write(spot);
  }

  /** null: lets go. */
  hold(spot: Spot | null): void {
    this.held = spot;
    this.write(spot);
  }

  private write(spot: Spot | null): void {
    this.host.hidden = spot === null;
    const tools = document.querySelector<HTMLElement>('.tools-bottom');
    this.host.style.bottom = `${(tools?.offsetHeight ?? 0) + 20}px`;
    this.button.hidden = this.held === null;
    this.words.value = spot ? spotLines(spot).join('\n') : '';
  }
}
