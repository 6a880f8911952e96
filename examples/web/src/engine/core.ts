// SPDX-License-Identifier: Apache-2.0
// The core's calls, in the page's terms. What lacks bytes says which.
import type { Camera, Look, Plane, VolumeInfo } from '../protocol';
import type { Range } from './ranges';

const wouldBlock = 40; // BCCSPLAT_ERROR_WOULD_BLOCK
const readWouldBlock = -65536;
const mostRanges = 256;

export interface CoreModule {
  HEAPU8: Uint8Array;
  HEAPF32: Float32Array;
  HEAPF64: Float64Array;
  readAt: (offset: number, buffer: number, size: number) => number;
  GL: {
    registerContext(context: WebGL2RenderingContext, attributes: object): number;
    makeContextCurrent(context: number): boolean;
  };
  UTF8ToString(at: number): string;
  _malloc(size: number): number;
  _free(at: number): void;
  [name: string]: unknown;
}

export class CoreError extends Error {
  constructor(
    readonly status: number,
    text: string,
  ) {
    super(text);
  }
}

// Bytes that a call lacks; made again when they are here it goes on.
export class Lacking extends Error {
  constructor(readonly ranges: Range[]) {
    super('bytes are on their way');
  }
}

export interface Drawn {
  camera: Camera;
  level: number;
  ms: number;
}

type Reading = (offset: number, out: Uint8Array) => boolean;

export class Core {
  private readonly pairs: number;
  constructor(private readonly m: CoreModule) {
    this.pairs = m._malloc(16 * mostRanges);
  }

  private call(name: string, ...values: number[]): number {
    return (this.m[`_web_${name}`] as (...v: number[]) => number)(...values);
  }
  private text(): string {
    return this.m.UTF8ToString(this.call('text'));
  }

  // Makes a call whose status says how it went.
  private ask(name: string, ...values: number[]): string {
    const status = this.call(name, ...values);
    if (status === 0) return this.text();
    if (status === wouldBlock) throw new Lacking(this.ranges(this.call('lacking', this.pairs, mostRanges)));
    throw new CoreError(status, this.text());
  }
  private ranges(count: number): Range[] {
    const from = this.pairs / 8;
    return Array.from({ length: count }, (_, n) => ({
      offset: this.m.HEAPF64[from + 2 * n],
      size: this.m.HEAPF64[from + 2 * n + 1],
    }));
  }

  // Copies numbers into the module's memory while a call lasts.
  private withNumbers<T>(lists: number[][], body: (at: number[]) => T): T {
    const at = lists.map((list) => {
      const place = this.m._malloc(8 * Math.max(list.length, 1));
      this.m.HEAPF64.set(list, place / 8);
      return place;
    });
    try {
      return body(at);
    } finally {
      at.forEach((place) => this.m._free(place));
    }
  }

  context!: WebGL2RenderingContext; // asked for once: Firefox's workers give it once

  // False where the canvas has no WebGL2, or none that draws floats.
  makeContext(canvas: OffscreenCanvas | HTMLCanvasElement): boolean {
    const attributes = { alpha: false, depth: false, antialias: false, powerPreference: 'high-performance' };
    const context = canvas.getContext('webgl2', attributes) as WebGL2RenderingContext | null;
    if (!context?.getExtension('EXT_color_buffer_float')) return false;
    this.context = context;
    const handle = this.m.GL.registerContext(context, { majorVersion: 2, minorVersion: 0, enableExtensionsByDefault: 1 });
    return this.m.GL.makeContextCurrent(handle);
  }

  open(size: number, read: Reading): VolumeInfo {
    this.m.readAt = (offset, buffer, count) =>
      read(offset, this.m.HEAPU8.subarray(buffer, buffer + count)) ? count : readWouldBlock;
    return JSON.parse(this.ask('open', size)) as VolumeInfo;
  }

  look(channel: number, look: number, mode: number): Look {
    return JSON.parse(this.ask('look', channel, look, mode)) as Look;
  }

  setFunction(colors: number[], opacities: number[], density: number): void {
    this.withNumbers([colors, opacities], ([c, o]) =>
      this.call('set_function', c, colors.length / 4, o, opacities.length / 2, density),
    );
  }
  setPicture(channel: number, mode: number, quality: number, shading: boolean, iso: number): void {
    this.call('set_picture', channel, mode, quality, shading ? 1 : 0, iso);
  }
  setView(perspective: boolean, turnX: number, turnY: number, zoom: number, panX: number, panY: number): void {
    this.call('set_view', perspective ? 1 : 0, turnX, turnY, zoom, panX, panY);
  }
  setClip(box: number[]): void {
    this.withNumbers([box], ([b]) => this.call('set_clip', b));
  }

  cut(time: number, width: number, height: number, preview: boolean, planes: boolean): void {
    this.ask('cut', time, width, height, preview ? 1 : 0, planes ? 1 : 0);
  }
  draw(width: number, height: number, background: [number, number, number], keepExposure: boolean): Drawn {
    return JSON.parse(this.ask('draw', width, height, ...background, keepExposure ? 1 : 0)) as Drawn;
  }

  // What cutting the moments from one time to another lacks; throws Lacking where not even that is known.
  lacking(from: number, to: number): Range[] {
    const count = this.call('ranges', from, to, this.pairs, mostRanges);
    if (count === -wouldBlock) throw new Lacking(this.ranges(this.call('lacking', this.pairs, mostRanges)));
    return count > 0 ? this.ranges(count) : [];
  }

  plane(axis: number, at: number, width: number, height: number): Plane {
    const place = this.m._malloc(4 * width * height);
    try {
      this.ask('plane', axis, at, width, height, place);
      return { width, height, values: this.m.HEAPF32.slice(place / 4, place / 4 + width * height) };
    } finally {
      this.m._free(place);
    }
  }
  value(at: [number, number, number]): number {
    return this.call('value', ...at);
  }

  // True from the loss on, of which the event may tell later.
  get isLost(): boolean {
    return this.context.isContextLost();
  }
  loseContext(): void {
    this.call('lose_context');
  }
  renew(): void {
    this.ask('renew');
  }
}
