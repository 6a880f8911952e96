// SPDX-License-Identifier: Apache-2.0
// The viewer as one element: what a page, or a notebook, puts where it likes.
import type { Camera, FromEngine, Look, Traffic, View, VolumeInfo } from '../protocol';
import { Shades } from './colors';
import { element, themed } from './dom';
import { bytes } from './format';
import { addGestures } from './gestures';
import { Link } from './link';
import { Overlay } from './overlay';
import { Panel } from './panel';
import { Planes, type PlanesSeen } from './planes';
import { compose, composed, download, Film, savePicture } from './save';
import { startView } from './state';
import { Timeline } from './timeline';
import { Transfer } from './transfer';

export interface Options {
  url?: string;
  view?: Partial<View>;
  // Where worker.mjs, core.mjs and core.wasm are; default: beside this module.
  base?: string;
  // Without panel and timeline: the picture alone.
  bare?: boolean;
  // Called when the view has come to rest.
  onview?: (view: View) => void;
}

const filmPictures = 96;
const millisecondsPerPicture = 1000 / 24;

export class Viewer {
  readonly root = element('div', { class: 'bccsplat empty' });
  view: View;
  info: VolumeInfo | undefined;
  traffic: Traffic = { bytes: 0, requests: 0, pending: 0 };

  private readonly stage = element('div', {
    class: 'stage',
    tabindex: 0,
    role: 'application',
    'aria-label':
      'Volume. Arrow keys turn it, with shift move it, plus and minus enlarge it, space plays, comma and point step by frames, s shows planes, 0 fits it',
  });
  private readonly overlay = new Overlay(element('canvas', { class: 'overlay', 'aria-hidden': 'true' }));
  private readonly status = element('div', { class: 'status', role: 'status' });
  private readonly notice = element('div', { class: 'notice', role: 'alert', hidden: true });
  private readonly link: Link;
  private readonly panel: Panel;
  private readonly planes: Planes;
  private readonly transfer: Transfer;
  private readonly timeline: Timeline;
  private canvas: HTMLCanvasElement | undefined;
  private look: Look | undefined;
  private planesSeen: PlanesSeen | undefined;
  private camera: Camera | undefined;
  private drawnTime = 0;
  private behind = 0; // views that were sent and are not drawn
  private waiting = false;
  private frameAsked = false;
  private moving = false;
  private name = 'volume';
  private snapshots = new Map<number, { done: (image: ImageBitmap) => void; failed: (e: Error) => void }>();
  private films = false;

  constructor(private readonly options: Options = {}) {
    this.view = { ...startView(), ...options.view };
    const view = () => this.view;
    const changed = (moving: boolean) => this.changed(moving);
    this.transfer = new Transfer(view, changed);
    this.planes = new Planes(view, changed);
    this.panel = new Panel(view, changed, this.transfer, this.actions());
    this.timeline = new Timeline({
      time: () => this.view.time,
      setTime: (time, moving) => {
        this.view.time = time;
        this.changed(moving);
      },
      ahead: (from, to) => this.link.send({ kind: 'ahead', from, to }),
      waits: () => this.waiting || this.behind > 0,
    });
    this.stage.append(this.overlay.canvas, this.notice, this.status);
    const main = element('div', { class: 'main' }, this.stage, this.planes.root);
    this.root.append(element('div', { class: 'work' }, main, this.panel.root), this.timeline.root);
    this.link = new Link(options.base ?? import.meta.url, () => this.freshCanvas(), (m) => this.hear(m));
    addGestures(this.stage, {
      view: this.view,
      changed,
      toggle: (what) => (what === 'play' ? this.timeline.toggle() : this.togglePlanes()),
      step: (frames) => this.timeline.step(frames),
      home: () => this.home(),
    });
    new ResizeObserver(() => this.changed(false)).observe(this.stage);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.changed(false));
    this.root.classList.toggle('bare', options.bare ?? false);
    if (options.url) this.openUrl(options.url);
  }

  private actions(): HTMLElement {
    const button = (text: string, act: () => void) => element('button', { type: 'button', click: act }, text);
    return element(
      'div',
      { class: 'actions' },
      button('Reset view', () => this.home()),
      button('Save picture', () => void this.savePicture()),
      button('Save film', () => void this.saveFilm()),
    );
  }

  private freshCanvas(): HTMLCanvasElement {
    this.canvas?.remove();
    this.canvas = element('canvas', { class: 'picture', 'aria-hidden': 'true' });
    this.stage.prepend(this.canvas);
    return this.canvas;
  }

  openUrl(url: string): void {
    const whole = new URL(url, location.href).href;
    this.name = decodeURIComponent(whole.split('/').pop() ?? 'volume').replace(/\.bcc4.*$/, '');
    this.begin();
    this.link.send({ kind: 'open', url: whole });
  }
  openFile(file: File): void {
    this.name = file.name.replace(/\.bcc4$/, '');
    this.begin();
    this.link.send({ kind: 'open', file });
  }
  private begin(): void {
    if (this.info) this.view.window = this.view.iso = null; // values of the file before
    this.info = undefined;
    this.look = this.camera = this.planesSeen = undefined;
    this.behind = 0;
    this.endSnapshots();
    this.say(`Opening ${this.name} …`);
  }

  private say(text: string, failed = false): void {
    this.notice.hidden = text === '';
    this.notice.textContent = text;
    this.notice.classList.toggle('failed', failed);
  }

  private hear(message: FromEngine): void {
    if (message.kind === 'opened') this.opened(message.info);
    else if (message.kind === 'look') this.gotLook(message.look);
    else if (message.kind === 'drawn') this.drawn(message);
    else if (message.kind === 'planes') this.gotPlanes(message);
    else if (message.kind === 'traffic') this.showTraffic(message.traffic);
    else if (message.kind === 'waiting') this.waits(true);
    else if (message.kind === 'snapshot') this.gotSnapshot(message.id, message.image);
    else if (message.kind === 'lost') this.lost();
    else if (message.kind === 'restored') this.say('');
    else if (message.kind === 'failed') this.failed(message.text);
    else if (message.kind === 'no-webgl2') this.failed(noWebgl2);
  }

  private opened(info: VolumeInfo): void {
    this.info = info;
    this.root.classList.remove('empty');
    this.say('');
    const end = Math.max(info.timeEnd, info.times[0]);
    this.view.time = Math.min(Math.max(this.view.time, info.times[0]), end);
    this.view.channel = Math.min(this.view.channel, info.channels.length - 1);
    this.panel.open(info);
    this.timeline.open(info);
    this.changed(false);
  }

  private failed(text: string): void {
    this.waits(false);
    this.behind = 0;
    this.timeline.stop();
    this.endSnapshots();
    this.say(text, true);
  }

  private lost(): void {
    this.timeline.stop();
    this.endSnapshots();
    this.camera = undefined; // nothing is drawn until it is back
    delete this.root.dataset.drawn;
    this.say(lostContext, true);
  }

  private waits(on: boolean): void {
    this.waiting = on;
    this.stage.setAttribute('aria-busy', String(on));
  }

  private gotLook(look: Look): void {
    this.look = look;
    this.panel.show(look.iso);
    this.drawTransfer();
  }
  private shades(): Shades | undefined {
    return this.look && new Shades(this.look, this.view.window);
  }
  private drawTransfer(): void {
    const shades = this.shades();
    if (!shades || !this.info) return;
    this.transfer.draw(this.info.channels[this.view.channel], shades);
    if (this.planesSeen && this.view.planes) this.planes.draw(this.planesSeen, this.info, shades);
  }

  private drawn(message: Extract<FromEngine, { kind: 'drawn' }>): void {
    if (!this.info) return;
    this.behind = 0;
    this.waits(message.preview);
    this.camera = message.camera;
    this.drawnTime = message.time;
    this.root.dataset.drawn = String(message.time);
    this.say('');
    this.drawOverlay();
  }
  private drawOverlay(): void {
    if (!this.info || !this.camera) return;
    const { info, view, camera, drawnTime: time } = this;
    this.overlay.draw({ info, view, camera, shades: this.shades(), time });
  }

  private gotPlanes(planes: PlanesSeen): void {
    this.planesSeen = planes;
    const shades = this.shades();
    if (this.info && shades) this.planes.draw(planes, this.info, shades);
  }

  private showTraffic(traffic: Traffic): void {
    this.traffic = traffic;
    const of = this.info ? ` of ${bytes(this.info.bytes)}` : '';
    const now = traffic.pending ? ' · reading' : '';
    this.status.textContent = `${bytes(traffic.bytes)}${of} read · ${traffic.requests} requests${now}`;
  }

  private changed(moving: boolean): void {
    this.moving = moving;
    if (this.frameAsked) return;
    this.frameAsked = true;
    requestAnimationFrame(() => this.send());
  }

  private background(): [number, number, number] {
    const numbers = themed('--stage', this.root).match(/[\d.]+/g)?.map(Number) ?? [0, 0, 0];
    const linear = (x: number) => (x <= 10.31475 ? x / 255 / 12.92 : ((x / 255 + 0.055) / 1.055) ** 2.4);
    return numbers.slice(0, 3).map(linear) as [number, number, number];
  }

  private send(): void {
    this.frameAsked = false;
    this.timeline.show();
    this.root.classList.toggle('with-planes', this.view.planes);
    if (!this.info || this.films) return;
    const ratio = Math.min(devicePixelRatio, 2);
    const width = Math.round(this.stage.clientWidth * ratio), height = Math.round(this.stage.clientHeight * ratio);
    if (width < 1 || height < 1) return;
    ++this.behind;
    const view = structuredClone(this.view);
    this.link.send({ kind: 'view', view, width, height, background: this.background(), moving: this.moving });
    this.drawTransfer();
    if (this.camera) this.drawOverlay();
    if (!this.moving) this.options.onview?.(view);
    else this.restSoon();
  }

  private resting: ReturnType<typeof setTimeout> | undefined;
  private restSoon(): void {
    clearTimeout(this.resting);
    this.resting = setTimeout(() => {
      if (!this.timeline.isPlaying) this.changed(false);
    }, 300);
  }

  private togglePlanes(): void {
    this.view.planes = !this.view.planes;
    this.panel.show(this.look?.iso);
  }

  // After the view was changed from outside.
  refresh(): void {
    this.panel.show(this.look?.iso);
    this.changed(false);
  }

  home(): void {
    const { turnX, turnY, zoom, panX, panY } = startView();
    Object.assign(this.view, { turnX, turnY, zoom, panX, panY });
    this.changed(false);
  }

  private snapshot(): Promise<ImageBitmap> {
    const id = this.snapshots.size + Date.now();
    return new Promise((done, failed) => {
      this.snapshots.set(id, { done, failed });
      this.link.send({ kind: 'snapshot', id });
    });
  }
  private gotSnapshot(id: number, image: ImageBitmap): void {
    this.snapshots.get(id)?.done(image);
    this.snapshots.delete(id);
  }
  // Of those that wait none comes any more; the page says why.
  private endSnapshots(): void {
    for (const { failed } of this.snapshots.values()) failed(new NoSnapshot());
    this.snapshots.clear();
  }

  async savePicture(): Promise<void> {
    if (!this.camera) return;
    const image = await this.snapshot().catch(unlessNone);
    if (image) await savePicture(composed(image, this.overlay.canvas), `${this.name}.png`);
  }

  // The whole series, moment by moment.
  async saveFilm(): Promise<void> {
    if (!this.info || !this.camera || this.films) return;
    this.timeline.stop();
    const before = this.view.time, { info } = this;
    try {
      await this.film(info).catch(unlessNone);
    } finally {
      this.films = false;
      if (this.info === info) this.view.time = before;
      this.changed(false);
    }
  }

  private async film(info: VolumeInfo): Promise<void> {
    const { times, timeEnd } = info;
    let film: Film | undefined;
    for (let n = 0; n < filmPictures; ++n) {
      if (this.info !== info) throw new NoSnapshot();
      this.films = false;
      this.view.time = times[0] + ((timeEnd - times[0]) * n) / (filmPictures - 1);
      this.send();
      this.films = true;
      const image = await this.snapshot();
      this.drawnTime = this.view.time;
      this.drawOverlay();
      film ??= new Film(composedSize(image));
      compose(film.canvas, image, this.overlay.canvas);
      await film.add(millisecondsPerPicture);
      this.say(`Film: ${n + 1} of ${filmPictures} pictures`);
    }
    download(await film!.end(), `${this.name}.webm`);
    this.say('');
  }

  end(): void {
    this.link.end();
    this.root.remove();
  }
}

class NoSnapshot extends Error {}
function unlessNone(e: unknown): void {
  if (!(e instanceof NoSnapshot)) throw e;
}

function composedSize(image: ImageBitmap): HTMLCanvasElement {
  return element('canvas', { width: image.width, height: image.height });
}

const noWebgl2 =
  'This browser gives no WebGL2 with float textures, which the picture needs. Update it or its graphics driver, ' +
  'switch hardware acceleration on, or try another browser.';

const lostContext =
  'The browser has lost its graphics context, as when a driver restarts. The picture comes back with a new one; if it ' +
  'does not, reload the page.';

// Puts a viewer into an element of a page.
export function createViewer(into: HTMLElement, options: Options = {}): Viewer {
  const viewer = new Viewer(options);
  into.append(viewer.root);
  return viewer;
}
