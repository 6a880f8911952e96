// SPDX-License-Identifier: Apache-2.0
// The engine as the page sees it: in a worker, or where a worker cannot draw, in the page itself.
import type { FromEngine, ToEngine } from '../protocol';
import type { Engine } from '../engine/engine';

type Heard = (message: FromEngine) => void;

export class Link {
  private worker: Worker | undefined;
  private engine: Engine | undefined;

  // makeCanvas: gives a fresh canvas, for one that a worker has cannot come back.
  constructor(
    private readonly base: string,
    private readonly makeCanvas: () => HTMLCanvasElement,
    private readonly heard: Heard,
  ) {
    const canvas = makeCanvas();
    if (typeof Worker === 'undefined' || !canvas.transferControlToOffscreen) void this.startHere(canvas);
    else this.startWorker(canvas);
  }

  private get core(): string {
    return new URL('core.mjs', this.base).href;
  }

  private startWorker(canvas: HTMLCanvasElement): void {
    const source = new URL('worker.mjs', this.base).href;
    // A worker's script must be of the page's origin; another one is loaded by a script that is.
    const script = new Blob([`import ${JSON.stringify(source)};`], { type: 'text/javascript' });
    const same = new URL(source).origin === location.origin;
    this.worker = new Worker(same ? source : URL.createObjectURL(script), { type: 'module' });
    this.worker.onmessage = (e: MessageEvent<FromEngine>) => {
      if (e.data.kind === 'no-webgl2') this.fallBack();
      else this.heard(e.data);
    };
    this.worker.onerror = (e) => {
      e.preventDefault();
      this.fallBack();
    };
    const offscreen = canvas.transferControlToOffscreen();
    this.worker.postMessage({ kind: 'start', canvas: offscreen, core: this.core } satisfies ToEngine, [offscreen]);
  }

  private fallBack(): void {
    if (!this.worker) return;
    this.worker.terminate();
    this.worker = undefined;
    void this.startHere(this.makeCanvas());
  }

  private async startHere(canvas: HTMLCanvasElement): Promise<void> {
    const { Engine } = await import('../engine/engine');
    this.engine = new Engine(this.heard);
    await this.engine.hear({ kind: 'start', canvas, core: this.core });
    for (const message of this.sent) void this.engine.hear(message);
  }

  private sent: ToEngine[] = []; // what a second engine has to hear again
  send(message: ToEngine): void {
    if (message.kind === 'open') this.sent = [message];
    if (message.kind === 'view') this.sent = [...this.sent.filter((m) => m.kind !== 'view'), message];
    if (this.worker) this.worker.postMessage(message);
    else void this.engine?.hear(message);
  }

  end(): void {
    this.worker?.terminate();
  }
}
