// SPDX-License-Identifier: Apache-2.0
// A look's colours and opacities at values, and as the display shows them.
import { fitted } from '../engine/window';
import type { Look } from '../protocol';

export type Rgb = [number, number, number];

// Linear light to the display's bytes.
export function encoded(x: number): number {
  const c = Math.min(Math.max(x, 0), 1);
  return Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
}

// Returns columns 1 .. width-1 of points with rising values, at a value.
function at(points: number[], width: number, value: number): number[] {
  const count = points.length / width;
  const row = (n: number) => points.slice(n * width + 1, (n + 1) * width);
  if (value <= points[0]) return row(0);
  for (let n = 1; n < count; ++n) {
    const to = points[n * width];
    if (value > to) continue;
    const from = points[(n - 1) * width];
    const share = to > from ? (value - from) / (to - from) : 1;
    const a = row(n - 1);
    return row(n).map((b, i) => a[i] + (b - a[i]) * share);
  }
  return row(count - 1);
}

export class Shades {
  private readonly colors: number[];
  private readonly opacities: number[];
  readonly range: [number, number];
  constructor(look: Look, window: [number, number] | null) {
    ({ colors: this.colors, opacities: this.opacities } = fitted(look, window));
    this.range = window ?? look.range;
  }
  color(value: number): Rgb {
    return at(this.colors, 4, value).map(encoded) as Rgb;
  }
  opacity(value: number): number {
    return at(this.opacities, 2, value)[0];
  }
  // What pixels of a value have: the colours of the range in 256 steps, and of labels each its own, however many
  // numbers the range has.
  pixels(labels: boolean): (value: number) => ArrayLike<number> {
    const [from, to] = this.range;
    const known = new Map<number, ArrayLike<number>>();
    const pixel = (key: number, value: number) => {
      let rgba = known.get(key);
      if (!rgba) known.set(key, (rgba = [...this.color(value), 255]));
      return rgba;
    };
    if (labels) return (value) => pixel(value, value);
    const scale = to > from ? 255 / (to - from) : 0;
    return (value) => {
      const shade = Math.max(0, Math.min(255, Math.round((value - from) * scale)));
      return pixel(shade, from + ((to - from) * shade) / 255);
    };
  }
}
