// SPDX-License-Identifier: Apache-2.0
// The transfer function over the histogram of the stored samples. The two handles are the ends of its range;
// dragging between them moves it as a whole.
import type { Channel, View } from '../protocol';
import type { Shades } from './colors';
import { element, sized, themed } from './dom';
import { number } from './format';

const grip = 14; // pixels around a handle that are its

export class Transfer {
  readonly canvas = element('canvas', {
    class: 'transfer',
    tabindex: 0,
    role: 'slider',
    'aria-label': 'Range of the colours: arrow keys move it, with shift the upper end, with alt the lower end',
  });
  private channel: Channel | undefined;
  private shades: Shades | undefined;
  private held: 'low' | 'high' | 'both' | undefined;
  private lastX = 0;

  constructor(
    private readonly view: () => View,
    private readonly changed: (moving: boolean) => void,
  ) {
    this.canvas.addEventListener('pointerdown', (e) => this.take(e));
    this.canvas.addEventListener('pointermove', (e) => this.drag(e));
    this.canvas.addEventListener('pointerup', () => {
      this.held = undefined;
      this.changed(false);
    });
    this.canvas.addEventListener('dblclick', () => {
      this.view().window = null;
      this.changed(false);
    });
    this.canvas.addEventListener('keydown', (e) => this.key(e));
  }

  private get span(): [number, number] {
    const [from, to] = this.channel!.keptRange;
    return to > from ? [from, to] : [from, from + 1];
  }
  private xOf(value: number): number {
    const [from, to] = this.span;
    return ((value - from) / (to - from)) * this.canvas.clientWidth;
  }
  private move(low: number, high: number): void {
    const least = (this.span[1] - this.span[0]) / 500;
    this.view().window = high - low >= least ? [low, high] : [low, low + least];
    this.changed(this.held !== undefined);
  }

  private take(e: PointerEvent): void {
    if (!this.shades) return;
    this.canvas.setPointerCapture(e.pointerId);
    const [low, high] = this.shades.range.map((v) => Math.abs(this.xOf(v) - e.offsetX));
    this.held = Math.min(low, high) > grip ? 'both' : low < high ? 'low' : 'high';
    this.lastX = e.offsetX;
  }
  private drag(e: PointerEvent): void {
    if (!this.held || !this.shades) return;
    const [from, to] = this.span;
    const by = ((e.offsetX - this.lastX) / this.canvas.clientWidth) * (to - from);
    this.lastX = e.offsetX;
    const [low, high] = this.shades.range;
    this.move(this.held === 'high' ? low : low + by, this.held === 'low' ? high : high + by);
  }
  private key(e: KeyboardEvent): void {
    const way = e.key === 'ArrowRight' ? 1 : e.key === 'ArrowLeft' ? -1 : 0;
    if (!way || !this.shades) return;
    e.preventDefault();
    const by = (way * (this.span[1] - this.span[0])) / 100;
    const [low, high] = this.shades.range;
    this.move(e.shiftKey ? low : low + by, e.altKey ? high : high + by);
  }

  draw(channel: Channel, shades: Shades): void {
    this.channel = channel;
    this.shades = shades;
    this.canvas.setAttribute('aria-valuetext', shades.range.map(number).join(' to '));
    const c = sized(this.canvas);
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight - 16;
    this.drawHistogram(c, width, height);
    this.drawColors(c, width, height);
    this.drawOpacity(c, width, height);
    this.drawHandles(c, height);
  }

  // One shape, smoothed over neighbours: values of whole numbers leave a comb.
  private drawHistogram(c: CanvasRenderingContext2D, width: number, height: number): void {
    const counts = this.channel!.histogram;
    const near = (n: number) => counts[Math.max(0, Math.min(counts.length - 1, n))];
    const heights = counts.map((count, n) => Math.log1p((near(n - 1) + 2 * count + near(n + 1)) / 4));
    const most = Math.max(...heights, 1);
    c.fillStyle = themed('--bars', this.canvas);
    c.beginPath();
    c.moveTo(0, height);
    heights.forEach((h, n) => c.lineTo(((n + 0.5) / counts.length) * width, height - (h / most) * (height - 12)));
    c.lineTo(width, height);
    c.fill();
  }
  private drawColors(c: CanvasRenderingContext2D, width: number, height: number): void {
    const [from, to] = this.span;
    for (let x = 0; x < width; x += 2) {
      c.fillStyle = `rgb(${this.shades!.color(from + ((to - from) * x) / width).join()})`;
      c.fillRect(x, height - 5, 2, 5);
    }
  }
  private drawOpacity(c: CanvasRenderingContext2D, width: number, height: number): void {
    const [from, to] = this.span;
    c.strokeStyle = themed('--accent', this.canvas);
    c.lineWidth = 1.5;
    c.beginPath();
    for (let x = 0; x <= width; x += 2) {
      const opacity = Math.sqrt(Math.max(0, this.shades!.opacity(from + ((to - from) * x) / width)));
      const y = (height - 6) * (1 - opacity) + 1;
      if (x === 0) c.moveTo(x, y);
      else c.lineTo(x, y);
    }
    c.stroke();
  }
  private drawHandles(c: CanvasRenderingContext2D, height: number): void {
    c.font = '11px system-ui, sans-serif';
    c.textBaseline = 'top';
    this.shades!.range.forEach((value, n) => {
      const x = Math.max(1, Math.min(this.canvas.clientWidth - 1, this.xOf(value)));
      c.fillStyle = themed('--ink', this.canvas);
      c.fillRect(x - 1, 0, 2, height);
      c.textAlign = n ? 'right' : 'left';
      c.fillText(number(value), n ? Math.max(x, 60) : Math.min(x, this.canvas.clientWidth - 60), height + 3);
    });
  }
}
