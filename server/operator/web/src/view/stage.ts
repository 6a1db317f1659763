// The canvas: renderer, the two cameras and their controls. Draws when something changed, and only then.

import { Box3, Color, Group, type Object3D, OrthographicCamera, PerspectiveCamera, Scene, Vector2, Vector3, WebGLRenderer, LinearSRGBColorSpace } from 'three';
import { MapControls } from 'three/addons/controls/MapControls.js';

export type Way = 'top' | 'free';

const fieldOfView_deg = 45;
const tools_px = 62; // lie over the picture's upper edge, and as much at least over its lower one
const beside_px = 28;
const rest_ms = 300;

export class Stage {
  readonly scene = new Scene();
  /** What is drawn over the points: robots, edges, outlines. */
  readonly signs = new Group();
  readonly renderer: WebGLRenderer;
  readonly size = new Vector2(1, 1);
  way: Way = 'top';

  private readonly top = new OrthographicCamera(-50, 50, 50, -50, -5000, 5000);
  private readonly free = new PerspectiveCamera(fieldOfView_deg, 1, 0.5, 8000);
  private readonly topControls: MapControls;
  private readonly freeControls: MapControls;
  private readonly before: (() => boolean | void)[] = [];
  private drawing = false;
  /** The frame that the graphics card has not finished yet, of those whose time is taken. */
  private timed: { begun: number; moves: boolean; fence: WebGLSync } | null = null;
  /** Whether the view has just been moved: soon after the last move it is drawn once more. */
  moves = false;
  private rest = 0;

  constructor(
    readonly canvas: HTMLCanvasElement,
    private readonly onOperated: () => void,
    /** From the beginning of a frame until the graphics card was done with it, as seen at the frame after; whether the view moved. */
    private readonly onTook: (frame_ms: number, moved: boolean) => void,
  ) {
    this.renderer = new WebGLRenderer({ canvas, antialias: false, powerPreference: 'high-performance' });
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.debug.checkShaderErrors = false; // it would wait for the graphics process
    document.addEventListener('visibilitychange', () => (this.timed = null)); // no frames are made meanwhile
    this.scene.add(this.signs);
    this.top.up.set(0, 1, 0);
    this.top.position.set(0, 0, 1000);
    this.free.up.set(0, 0, 1);
    this.free.position.set(0, -80, 70);
    this.topControls = new MapControls(this.top, canvas);
    this.topControls.enableRotate = false;
    this.topControls.screenSpacePanning = true;
    this.freeControls = new MapControls(this.free, canvas);
    this.freeControls.maxPolarAngle = Math.PI * 0.495;
    this.freeControls.enabled = false;
    for (const controls of [this.topControls, this.freeControls]) {
      controls.zoomToCursor = true;
      controls.enableDamping = false;
      controls.addEventListener('change', () => this.moved());
      controls.addEventListener('start', () => this.onOperated());
    }
    new ResizeObserver(() => this.fitCanvas()).observe(canvas.parentElement!);
    this.fitCanvas();
  }

  get camera(): OrthographicCamera | PerspectiveCamera {
    return this.way === 'top' ? this.top : this.free;
  }
  get target(): Vector3 {
    return this.controls.target;
  }
  private get controls(): MapControls {
    return this.way === 'top' ? this.topControls : this.freeControls;
  }

  /** Called before each frame; true: another frame is wanted. */
  onFrame(work: () => boolean | void): void {
    this.before.push(work);
  }

  /** Asks for the program that such an object needs: until one is drawn the graphics process has made it. */
  prepare(sample: Object3D): void {
    this.renderer.compile(sample, this.camera);
  }

  paint(background: string): void {
    this.scene.background = new Color().setStyle(background, 'srgb-linear');
    this.draw();
  }

  private moved(): void {
    this.moves = true;
    clearTimeout(this.rest);
    this.rest = window.setTimeout(() => {
      this.moves = false;
      this.draw();
    }, rest_ms);
    this.draw();
  }

  draw(): void {
    if (this.drawing) return;
    this.drawing = true;
    requestAnimationFrame(() => {
      const begun = performance.now();
      this.drawing = false;
      this.camera.updateMatrixWorld();
      let again = false;
      for (const work of this.before) again = work() === true || again;
      this.renderer.render(this.scene, this.camera);
      this.time(begun);
      if (again) this.draw();
    });
  }

  private time(begun: number): void {
    if (this.timed) return; // one at a time
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    if (!fence) return; // the context was lost
    const timed = (this.timed = { begun, moves: this.moves, fence });
    const look = () => {
      const done = gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.SIGNALED;
      if (!done && this.timed === timed) return void requestAnimationFrame(look);
      gl.deleteSync(fence);
      if (this.timed !== timed) return;
      this.timed = null;
      this.onTook(performance.now() - begun, timed.moves);
    };
    requestAnimationFrame(look);
  }

  /** Pixels of the canvas for a metre; at one metre's distance in the free view. */
  pixelsPerUnit(): number {
    const height = this.size.y * this.renderer.getPixelRatio();
    if (this.way === 'top') return (height * this.top.zoom) / (this.top.top - this.top.bottom);
    return height / (2 * Math.tan((fieldOfView_deg * Math.PI) / 360));
  }

  /** Metres for a pixel of the page at this place. */
  metresPerPixel(place: Vector3): number {
    const ratio = this.renderer.getPixelRatio();
    return this.way === 'top' ? ratio / this.pixelsPerUnit() : (ratio * this.free.position.distanceTo(place)) / this.pixelsPerUnit();
  }

  show(way: Way): void {
    if (way === this.way) return;
    const target = this.target.clone();
    const span_m = this.size.y * this.metresPerPixel(target);
    this.controls.enabled = false;
    this.way = way;
    this.controls.enabled = true;
    this.target.copy(target);
    if (way === 'top') {
      this.top.position.set(target.x, target.y, 1000);
      this.top.zoom = (this.top.top - this.top.bottom) / span_m;
    } else {
      const distance = span_m / (2 * Math.tan((fieldOfView_deg * Math.PI) / 360));
      this.free.position.set(target.x, target.y - 0.75 * distance, target.z + 0.66 * distance);
    }
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.draw();
  }

  /** All of the box in sight, over what covers so many pixels of the lower edge. */
  frame(box: Box3, covered_px = 0): void {
    if (box.isEmpty()) return;
    const centre = box.getCenter(new Vector3());
    const span = box.getSize(new Vector3());
    const lower_px = Math.min(Math.max(tools_px, covered_px), this.size.y / 2);
    const room = { x: Math.max(this.size.x - 2 * beside_px, 1), y: Math.max(this.size.y - tools_px - lower_px, 1) };
    const height = this.size.y * Math.max(span.y / room.y, span.x / room.x, 10 / this.size.y);
    centre.y -= (((lower_px - tools_px) / 2) * height) / this.size.y;
    this.target.copy(centre);
    if (this.way === 'top') {
      this.top.position.set(centre.x, centre.y, 1000);
      this.top.zoom = (this.top.top - this.top.bottom) / height;
    } else {
      const distance = height / (2 * Math.tan((fieldOfView_deg * Math.PI) / 360));
      this.free.position.set(centre.x, centre.y - 0.7 * distance, centre.z + 0.7 * distance);
    }
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.camera.updateMatrixWorld(); // for what is placed in this same frame
    this.draw();
  }

  /** By so many parts of the picture's height; for the keyboard. */
  pan(right: number, up: number): void {
    const span_m = this.size.y * this.metresPerPixel(this.target);
    const move = new Vector3(right * span_m, up * span_m, 0);
    if (this.way === 'free') {
      const ahead = this.target.clone().sub(this.free.position).setZ(0).normalize();
      move.set(ahead.y * right + ahead.x * up, -ahead.x * right + ahead.y * up, 0).multiplyScalar(span_m);
    }
    this.target.add(move);
    this.camera.position.add(move);
    this.controls.update();
    this.onOperated();
    this.draw();
  }

  /** The view goes along, without having been moved by hand. */
  follow(place: Vector3): void {
    const shift = place.clone().sub(this.target);
    if (this.way === 'top') shift.z = 0;
    if (shift.length() < 1e-3) return;
    this.target.add(shift);
    this.camera.position.add(shift);
    this.camera.updateMatrixWorld();
    this.draw();
  }

  zoom(factor: number): void {
    if (this.way === 'top') this.top.zoom *= factor;
    else this.free.position.sub(this.target).divideScalar(factor).add(this.target);
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.onOperated();
    this.draw();
  }

  /** Pixels of the page; z > 1 or < -1: behind or out of reach. */
  toPage(place: Vector3): Vector3 {
    const seen = place.clone().project(this.camera);
    return seen.set(((seen.x + 1) / 2) * this.size.x, ((1 - seen.y) / 2) * this.size.y, seen.z);
  }

  /** The place under a pixel of the page, as seen from above. */
  onGround(x: number, y: number): Vector2 {
    const metres = this.metresPerPixel(this.target);
    return new Vector2(this.top.position.x + (x - this.size.x / 2) * metres, this.top.position.y - (y - this.size.y / 2) * metres);
  }

  private fitCanvas(): void {
    const { clientWidth, clientHeight } = this.canvas.parentElement!;
    const size = new Vector2(Math.max(clientWidth, 1), Math.max(clientHeight, 1));
    if (size.equals(this.size) && this.renderer.getPixelRatio() === Math.min(devicePixelRatio, 2)) return;
    this.size.copy(size);
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(this.size.x, this.size.y, false);
    const half = 50;
    const aspect = this.size.x / this.size.y;
    Object.assign(this.top, { left: -half * aspect, right: half * aspect, top: half, bottom: -half });
    this.free.aspect = aspect;
    this.top.updateProjectionMatrix();
    this.free.updateProjectionMatrix();
    this.draw();
  }
}
