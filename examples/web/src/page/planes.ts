// SPDX-License-Identifier: Apache-2.0
// The x, y and z planes through the cross-hair, beside the picture: dragging in one moves the others.
import type { FromEngine, Plane, VolumeInfo, View } from '../protocol';
import type { Shades } from './colors';
import { element, sized, themed } from './dom';
import { closest, withUnit } from './format';
import { toWorld } from './project';

export type PlanesSeen = Extract<FromEngine, { kind: 'planes' }>;

const names = ['x', 'y', 'z'];
const across: [number, number][] = [
  [1, 2],
  [0, 2],
  [0, 1],
];
const axisColors = ['--axis-x', '--axis-y', '--axis-z'];

// A place of the world; along unevenly spaced axes it is the coordinate, which is in proportion to a fraction of
// the domain, from below where it counts down: then z rises as in the world, and as along even axes, and
// `bcc4 probe --at` takes it. A unit that all axes have is told once.
function placeText(info: VolumeInfo, at: View['cross']): string {
  const world = toWorld(info, at);
  const units = info.axes.map((axis) => axis.unit || info.spatialUnit);
  const one = units.every((unit) => unit === units[0]);
  const texts = info.axes.map(({ places, down }, a) => {
    const unit = one && a < 2 ? '' : units[a];
    if (places.length === 0) return withUnit(world[a], unit, Math.max(...info.affine.slice(4 * a, 4 * a + 3).map(Math.abs)));
    const first = places[0], last = places[places.length - 1];
    return withUnit((down ? -1 : 1) * (first + (last - first) * at[a]), unit, closest(places));
  });
  return texts.join(', ');
}

export class Planes {
  readonly root = element('section', { class: 'planes', 'aria-label': 'Planes through the cross-hair' });
  private readonly canvases: HTMLCanvasElement[] = [];
  private readonly read = element('output', { class: 'value', 'aria-live': 'polite' });

  constructor(
    private readonly view: () => View,
    private readonly moved: (moving: boolean) => void,
  ) {
    for (let axis = 0; axis < 3; ++axis) {
      const canvas = element('canvas', {
        tabindex: 0,
        role: 'img',
        'aria-label': `Plane ${names[axis]} = constant; arrow keys move the cross-hair, page keys the plane`,
      });
      this.canvases.push(canvas);
      this.root.append(element('figure', {}, canvas));
      this.listen(canvas, axis);
    }
    this.root.append(this.read);
  }

  private listen(canvas: HTMLCanvasElement, axis: number): void {
    const [u, v] = across[axis];
    const set = (a: number, x: number) => (this.view().cross[a] = Math.min(Math.max(x, 0), 1));
    const move = (e: PointerEvent) => {
      set(u, e.offsetX / canvas.clientWidth);
      set(v, 1 - e.offsetY / canvas.clientHeight);
      this.moved(true);
    };
    canvas.addEventListener('pointerdown', (e) => {
      canvas.setPointerCapture(e.pointerId);
      move(e);
    });
    canvas.addEventListener('pointermove', (e) => e.buttons && move(e));
    canvas.addEventListener('pointerup', () => this.moved(false));
    const by: Record<string, [number, number]> = {
      ArrowLeft: [u, -0.01],
      ArrowRight: [u, 0.01],
      ArrowUp: [v, 0.01],
      ArrowDown: [v, -0.01],
      PageUp: [axis, 0.01],
      PageDown: [axis, -0.01],
    };
    canvas.addEventListener('keydown', (e) => {
      const step = by[e.key];
      if (!step) return;
      e.preventDefault();
      set(step[0], this.view().cross[step[0]] + step[1]);
      this.moved(false);
    });
    canvas.addEventListener(
      'wheel',
      (e) => {
        e.preventDefault();
        set(axis, this.view().cross[axis] - Math.sign(e.deltaY) * 0.01);
        this.moved(true);
      },
      { passive: false },
    );
  }

  draw({ planes, value, channel: of, cross }: PlanesSeen, info: VolumeInfo, shades: Shades): void {
    const channel = info.channels[of];
    const pixel = shades.pixels(channel.labels !== 0);
    planes.forEach((plane, axis) => {
      const canvas = this.canvases[axis];
      const [u, v] = across[axis];
      const size = (a: number) => Math.hypot(...[0, 4, 8].map((row) => info.affine[row + a])) * info.across[a];
      canvas.style.aspectRatio = String(Math.max(0.4, Math.min(2.5, size(u) / Math.max(size(v), 1e-30))));
      const c = sized(canvas);
      c.imageSmoothingEnabled = !channel.labels;
      this.paint(c, canvas, plane, pixel);
      this.hair(canvas, axis, u, v);
    });
    this.read.textContent = `${channel.name} = ${withUnit(value, channel.unit)} at (${placeText(info, cross)})`;
  }

  private paint(
    c: CanvasRenderingContext2D,
    canvas: HTMLCanvasElement,
    plane: Plane,
    pixel: (value: number) => ArrayLike<number>,
  ): void {
    const image = new ImageData(plane.width, plane.height);
    for (let n = 0; n < plane.values.length; ++n) {
      const value = plane.values[n];
      const row = plane.height - 1 - Math.floor(n / plane.width);
      if (value === value) image.data.set(pixel(value), 4 * (row * plane.width + (n % plane.width)));
    }
    const whole = new OffscreenCanvas(plane.width, plane.height);
    whole.getContext('2d')!.putImageData(image, 0, 0);
    c.imageSmoothingQuality = 'high';
    c.drawImage(whole, 0, 0, canvas.clientWidth, canvas.clientHeight);
  }

  private hair(canvas: HTMLCanvasElement, axis: number, u: number, v: number): void {
    const c = canvas.getContext('2d')!;
    const { cross } = this.view();
    const x = cross[u] * canvas.clientWidth, y = (1 - cross[v]) * canvas.clientHeight;
    const stroke = (color: string, x0: number, y0: number, x1: number, y1: number) => {
      c.strokeStyle = themed(color, canvas);
      c.lineWidth = 1;
      c.beginPath();
      c.moveTo(x0, y0);
      c.lineTo(x1, y1);
      c.stroke();
    };
    stroke(axisColors[u], 0, y, canvas.clientWidth, y);
    stroke(axisColors[v], x, 0, x, canvas.clientHeight);
    c.fillStyle = themed(axisColors[axis], canvas);
    c.font = '600 12px system-ui, sans-serif';
    c.strokeStyle = themed('--stage', canvas);
    c.lineWidth = 3;
    c.lineJoin = 'round';
    c.strokeText(names[axis], 7, 16);
    c.fillText(names[axis], 7, 16);
  }
}
