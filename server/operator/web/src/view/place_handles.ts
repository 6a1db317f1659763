// What moves a map that is being placed: it is dragged itself, and turned by a handle over its outline or with Shift.

import { BufferGeometry, Float32BufferAttribute, LineBasicMaterial, LineLoop, Vector3 } from 'three';
import type { Frames } from './frames';
import type { Placing } from './placing';
import type { Stage } from './stage';

const over_px = 30; // from the outline to the handle
const inset_px = 24; // of the handle from what lies over the picture, when the outline reaches out of sight
const step_rad = Math.PI / 36;

interface Place {
  x: number;
  y: number;
}

export class PlaceHandles {
  private readonly outline = new LineLoop(new BufferGeometry(), new LineBasicMaterial({ depthTest: false, transparent: true }));
  private readonly handle = document.createElement('div');
  /** Where the pointer was last, and what it does. */
  private dragged: { from: Place; turns: boolean } | null = null;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    layer: HTMLElement,
    private readonly stage: Stage,
    private readonly frames: Frames,
    private readonly placing: Placing,
  ) {
    this.outline.frustumCulled = false;
    this.outline.renderOrder = 25;
    this.outline.visible = false;
    stage.signs.add(this.outline);
    this.handle.className = 'turn-handle';
    this.handle.tabIndex = 0;
    this.handle.textContent = '↻';
    for (const [name, value] of Object.entries({ role: 'slider', 'aria-label': 'Turn the map that is placed', 'aria-valuemin': '-180', 'aria-valuemax': '180', 'aria-valuenow': '0' })) this.handle.setAttribute(name, value);
    this.handle.hidden = true;
    layer.append(this.handle);
    this.listen();
  }

  paint(colour: string): void {
    this.outline.material.color.setStyle(colour, 'srgb-linear');
    this.handle.style.setProperty('--mark', colour);
  }

  beforeFrame(): void {
    const laid = this.frames.laidMap;
    this.outline.visible = laid !== null;
    this.handle.hidden = laid === null || this.stage.way !== 'top';
    if (!laid) return;
    const { min, max } = laid.box;
    const corners = [min.x, min.y, max.x, min.y, max.x, max.y, min.x, max.y];
    this.outline.geometry.dispose();
    this.outline.geometry = new BufferGeometry();
    this.outline.geometry.setAttribute('position', new Float32BufferAttribute([0, 1, 2, 3].flatMap((at) => [corners[2 * at], corners[2 * at + 1], 0]), 3));
    this.outline.matrixAutoUpdate = false;
    this.outline.matrix.copy(laid.T_world_component);
    this.outline.matrixWorldNeedsUpdate = true;
    const above = new Vector3((min.x + max.x) / 2, max.y + over_px * this.stage.metresPerPixel(this.stage.target), 0).applyMatrix4(laid.T_world_component);
    const { x, y } = this.stage.toPage(above);
    const { size } = this.stage;
    const [above_px, below_px] = ['.tools-above', '.tools-bottom'].map((tools) => (document.querySelector<HTMLElement>(tools)?.offsetHeight ?? 0) + 12 + inset_px);
    const left = Math.min(Math.max(x, inset_px), Math.max(size.x - inset_px, inset_px));
    const top = Math.max(Math.min(y, size.y - below_px), above_px);
    this.handle.style.transform = `translate(${left}px, ${top}px)`;
    const turned_deg = Math.round((this.placing.now!.turn_rad * 180) / Math.PI);
    this.handle.setAttribute('aria-valuenow', String(((((turned_deg + 180) % 360) + 360) % 360) - 180));
  }

  private listen(): void {
    // Before the map's own: what is dragged does not move the view as well.
    this.canvas.addEventListener('pointerdown', (event) => this.press(event, event.shiftKey, event.shiftKey || this.isOver(this.placeOf(event))), { capture: true });
    this.handle.addEventListener('pointerdown', (event) => this.press(event, true, true));
    for (const part of [this.canvas, this.handle] as HTMLElement[]) {
      part.addEventListener('pointermove', (event) => this.drag(event), { capture: true });
      for (const end of ['pointerup', 'pointercancel'] as const) part.addEventListener(end, (event) => this.release(event), { capture: true });
    }
    this.handle.addEventListener('keydown', (event) => {
      const turns = { ArrowLeft: 1, ArrowUp: 1, ArrowRight: -1, ArrowDown: -1 }[event.key];
      if (!turns) return;
      event.preventDefault();
      event.stopPropagation();
      this.placing.turn(turns * step_rad);
    });
  }

  private press(event: PointerEvent, turns: boolean, mine: boolean): void {
    if (!mine || event.button !== 0 || !this.frames.laidMap || this.stage.way !== 'top') return;
    event.stopImmediatePropagation();
    if (event.currentTarget === this.handle) event.preventDefault(); // no text is selected
    (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
    this.dragged = { from: this.placeOf(event), turns };
  }

  private drag(event: PointerEvent): void {
    const laid = this.frames.laidMap;
    if (!this.dragged || !laid) return;
    event.stopImmediatePropagation();
    const { from, turns } = this.dragged;
    const to = this.placeOf(event);
    this.dragged = { from: to, turns };
    if (!turns) return this.placing.move(to.x - from.x, to.y - from.y);
    const about = this.placing.now!.pivot.clone().applyMatrix4(laid.T_world_component);
    const angle = ({ x, y }: Place) => Math.atan2(y - about.y, x - about.x);
    this.placing.turn(angle(to) - angle(from));
  }

  private release(event: PointerEvent): void {
    if (!this.dragged) return;
    event.stopImmediatePropagation();
    this.dragged = null;
  }

  private isOver({ x, y }: Place): boolean {
    const laid = this.frames.laidMap;
    if (!laid) return false;
    const p = new Vector3(x, y, 0).applyMatrix4(laid.T_world_component.clone().invert());
    return p.x >= laid.box.min.x && p.x <= laid.box.max.x && p.y >= laid.box.min.y && p.y <= laid.box.max.y;
  }

  private placeOf({ clientX, clientY }: PointerEvent): Place {
    const { left, top } = this.canvas.getBoundingClientRect();
    return this.stage.onGround(clientX - left, clientY - top);
  }
}
