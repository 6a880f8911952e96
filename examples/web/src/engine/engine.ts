// SPDX-License-Identifier: Apache-2.0
// Draws what the page last asked for: reads what it lacks, draws when that is here, and drops what nobody
// looks at any more. It runs in a worker, or where none can draw in the page itself.
import type { FromEngine, Look, ToEngine, View } from '../protocol';
import { Core, CoreError, Lacking, type CoreModule } from './core';
import { Pace } from './pace';
import { Reader } from './reader';
import { SourceError } from './source';
import { fitted } from './window';

type Wanted = Extract<ToEngine, { kind: 'view' }>;

const draft = 1; // BCCSPLAT_QUALITY_DRAFT
const normal = 2;
const restMilliseconds = 250;
const largestPlane = 192; // samples of a plane along an axis

export class Engine {
  private core!: Core;
  private reader: Reader | undefined;
  private canvas!: OffscreenCanvas | HTMLCanvasElement;
  private wanted: Wanted | undefined;
  private dirty = false;
  private running = false;
  private drawnTime = NaN;
  private planesOf = '';
  private looks = new Map<string, Look>();
  private pace = new Pace(false);
  private dims: number[] = [1, 1, 1, 1];
  private levels = 0;
  private exposed = '';
  private lost = false;

  constructor(private readonly tell: (message: FromEngine, transfer?: Transferable[]) => void) {}

  private started: Promise<void> | undefined;

  private files = 0; // that were asked for: the last one is looked at, whichever opens last

  async hear(message: ToEngine): Promise<void> {
    const file = message.kind === 'open' ? ++this.files : this.files;
    try {
      if (message.kind === 'start') return await (this.started = this.start(message));
      await this.started;
      if (!this.core) return; // the page draws
      if (message.kind === 'open') await this.open(message, file);
      else if (message.kind === 'view') this.want(message);
      else if (message.kind === 'ahead') void this.ahead(message.from, message.to);
      else await this.snapshot(message.id);
    } catch (e) {
      if (file === this.files) this.fail(e);
    }
  }

  private async start(message: Extract<ToEngine, { kind: 'start' }>): Promise<void> {
    const load = (await import(message.core)) as { default: (o: object) => Promise<CoreModule> };
    this.core = new Core(await load.default({}));
    this.canvas = message.canvas;
    if (!this.canDraw()) {
      this.core = undefined as unknown as Core;
      return this.tell({ kind: 'no-webgl2' });
    }
    this.watchContext();
    const gl = this.core.context;
    const info = gl.getExtension('WEBGL_debug_renderer_info');
    const renderer = String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
    this.pace = new Pace(/llvmpipe|softpipe|SwiftShader|Basic Render/.test(renderer));
    this.tell({ kind: 'ready', renderer });
  }

  // Some browsers give workers no context, and say so by an exception.
  private canDraw(): boolean {
    try {
      return this.core.makeContext(this.canvas);
    } catch (e) {
      console.info(`No WebGL2 here: ${(e as Error).message}`);
      return false;
    }
  }

  private watchContext(): void {
    const canvas = this.canvas as HTMLCanvasElement;
    canvas.addEventListener('webglcontextlost', (e) => {
      e.preventDefault(); // or it does not come back
      this.lost = true;
      this.core.loseContext();
      this.tell({ kind: 'lost' });
    });
    canvas.addEventListener('webglcontextrestored', () => {
      this.core.context.getExtension('EXT_color_buffer_float');
      if (this.reader) this.core.renew();
      this.lost = false;
      this.tell({ kind: 'restored' });
      this.redraw();
    });
  }

  private async open(from: { url?: string; file?: Blob }, file: number): Promise<void> {
    this.reader?.dropPending();
    this.wanted = undefined;
    const reader = await Reader.open(from, (traffic) => {
      if (file === this.files) this.tell({ kind: 'traffic', traffic });
    });
    if (file !== this.files) return;
    this.reader = reader;
    this.looks.clear();
    this.told = '';
    this.drawnTime = NaN;
    this.planesOf = this.exposed = '';
    const info = await this.fetching(() => this.core.open(reader.size, (at, out) => reader.read(at, out)), reader);
    this.dims = info.dims;
    this.levels = info.levels;
    this.tell({ kind: 'opened', info });
  }

  // Makes a call again until nothing is lacking.
  private async fetching<T>(call: () => T, from = this.reader!): Promise<T> {
    for (;;) {
      try {
        return call();
      } catch (e) {
        if (!(e instanceof Lacking)) throw e;
        await from.fetch(e.ranges);
        if (from !== this.reader) throw new DOMException('another file is opened', 'AbortError');
      }
    }
  }

  private want(message: Wanted): void {
    const before = this.wanted;
    this.wanted = message;
    if (before && before.view.time !== message.view.time && !this.playsOn(before, message)) this.reader?.dropPending();
    this.redraw();
  }

  // Whether what is on its way for the moment before serves this one, too.
  private playsOn(before: Wanted, now: Wanted): boolean {
    return Math.abs(now.view.time - before.view.time) <= this.stride;
  }
  private stride = 0; // of the last layers that were asked for ahead

  private redraw(): void {
    this.dirty = true;
    if (!this.running && this.reader) void this.run();
  }

  private async run(): Promise<void> {
    this.running = true;
    while (this.dirty && this.wanted && !this.lost && !this.core.isLost) {
      this.dirty = false;
      try {
        await this.picture(this.wanted);
      } catch (e) {
        if (this.core.isLost || (e as Error).name === 'AbortError') this.dirty = true;
        else this.fail(e);
      }
      await new Promise((go) => setTimeout(go, 0)); // messages that came meanwhile
    }
    this.running = false;
  }

  // Where whole pictures take long a smaller one comes first.
  private async picture(given: Wanted): Promise<void> {
    const first = this.pace.slow && this.quick !== given;
    const wanted = first ? { ...given, moving: true } : given;
    const scale = wanted.moving ? this.pace.scale : 1;
    const width = Math.max(1, Math.round(wanted.width * scale)), height = Math.max(1, Math.round(wanted.height * scale));
    this.apply(wanted);
    try {
      this.core.cut(wanted.view.time, width, height, false, wanted.view.planes);
    } catch (e) {
      if (!(e instanceof Lacking)) throw e;
      this.preview(wanted, width, height);
      this.tell({ kind: 'waiting', time: wanted.view.time });
      await this.reader!.fetch(e.ranges);
      this.dirty = true;
      return;
    }
    this.show(wanted, width, height, false);
    if (wanted.moving && scale < 1 && !this.dirty) this.settleSoon(given);
  }
  private quick: Wanted | undefined; // whose small picture was there

  // A picture of the coarsest level, where its bytes are here or few.
  private preview(wanted: Wanted, width: number, height: number): void {
    if (this.levels === 0) return;
    try {
      this.core.cut(wanted.view.time, width, height, true, false);
      this.show(wanted, width, height, true);
    } catch (e) {
      if (!(e instanceof Lacking)) throw e;
      void this.reader!.fetch(e.ranges).then(() => this.redraw(), () => {});
    }
  }

  // Pictures that are drawn smaller while something moves are drawn whole when nothing does.
  private settleSoon(wanted: Wanted): void {
    setTimeout(() => {
      if (this.wanted !== wanted) return;
      this.wanted = this.quick = { ...wanted, moving: false };
      this.redraw();
    }, restMilliseconds);
  }

  private apply({ view, moving }: Wanted): void {
    const look = this.lookOf(view);
    this.tellLook(view);
    const { colors, opacities } = fitted(look, view.window);
    this.core.setFunction(colors, opacities, view.opacity);
    this.core.setPicture(view.channel, view.mode, moving ? draft : normal, view.shading, view.iso ?? look.iso);
    this.core.setView(view.perspective, view.turnX, view.turnY, view.zoom, view.panX, view.panY);
    this.core.setClip(view.clip);
  }

  private told = ''; // the look that the page has

  // The page's look is that of values: of a surface, which has one colour, what a composite would have.
  private tellLook(view: View): void {
    const mode = view.mode === 2 ? 1 : view.mode;
    const look = { ...this.lookOf({ ...view, mode }), iso: this.lookOf(view).iso };
    const of = `${view.channel} ${view.look} ${view.mode}`;
    if (this.told === of) return;
    this.told = of;
    this.tell({ kind: 'look', look, channel: view.channel });
  }

  private lookOf(view: View): Look {
    const key = `${view.channel} ${view.look} ${view.mode}`;
    let look = this.looks.get(key);
    if (!look) {
      look = this.core.look(view.channel, view.look, view.mode);
      this.looks.set(key, look);
    }
    return look;
  }

  private show(wanted: Wanted, width: number, height: number, preview: boolean): void {
    const start = performance.now();
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    // X-rays are exposed by their first picture, and once more by the first whole one.
    const exposure = `${wanted.view.channel} ${wanted.view.mode} ${wanted.moving ? '' : 'whole'}`;
    const drawn = this.core.draw(width, height, wanted.background, this.exposed.startsWith(exposure));
    if (!this.exposed.startsWith(exposure)) this.exposed = exposure;
    const ms = performance.now() - start;
    this.pace.took(ms, wanted.moving);
    this.drawnTime = wanted.view.time;
    this.tell({ kind: 'drawn', time: wanted.view.time, camera: drawn.camera, ms, level: drawn.level, preview });
    if (!preview && wanted.view.planes) this.planes(wanted, drawn.level);
  }

  private planes({ view, moving }: Wanted, level: number): void {
    const of = [view.time, view.channel, moving, level, ...view.cross].join(' ');
    if (of === this.planesOf) return;
    this.planesOf = of;
    const most = moving ? largestPlane / 2 : largestPlane;
    const size = (axis: number) => Math.min(this.dims[axis], most);
    const plane = (axis: number, u: number, v: number) =>
      this.core.plane(axis, view.cross[axis], size(u), size(v));
    const planes = [plane(0, 1, 2), plane(1, 0, 2), plane(2, 0, 1)];
    const value = this.core.value(view.cross);
    const { channel, cross } = view;
    this.tell({ kind: 'planes', planes, value, channel, cross }, planes.map((p) => p.values.buffer));
  }

  // Fetches the moments that will be played next.
  private async ahead(from: number, to: number): Promise<void> {
    if (!this.reader || Number.isNaN(this.drawnTime)) return;
    this.stride = Math.abs(to - from);
    try {
      const ranges = await this.fetching(() => this.core.lacking(from, to));
      await this.reader.fetch(ranges);
    } catch (e) {
      if ((e as Error).name !== 'AbortError') this.fail(e);
    }
  }

  private async snapshot(id: number): Promise<void> {
    if (!this.wanted) return;
    const wanted = { ...this.wanted, moving: false };
    const { width, height } = wanted;
    await this.fetching(() => {
      this.apply(wanted); // others are drawn while bytes come
      this.core.cut(wanted.view.time, width, height, false, wanted.view.planes);
    });
    this.show(wanted, width, height, false);
    const image = await createImageBitmap(this.canvas);
    this.tell({ kind: 'snapshot', id, image }, [image]);
  }

  private fail(e: unknown): void {
    const fatal = !this.wanted;
    if (e instanceof SourceError) this.tell({ kind: 'failed', text: e.message, fatal });
    else if (e instanceof CoreError) this.tell({ kind: 'failed', text: `The file cannot be shown: ${e.message}.`, fatal });
    else this.tell({ kind: 'failed', text: `Something went wrong: ${(e as Error).message ?? e}.`, fatal });
  }
}
