// SPDX-License-Identifier: Apache-2.0
// A look over another window of values than its own.
import type { Look } from '../protocol';

// Returns the look's points, moved so that its range becomes the window.
export function fitted(look: Look, window: [number, number] | null): { colors: number[]; opacities: number[] } {
  if (!window) return { colors: look.colors, opacities: look.opacities };
  const [from, to] = look.range;
  const factor = to > from ? (window[1] - window[0]) / (to - from) : 1;
  const moved = (value: number) => window[0] + (value - from) * factor;
  const move = (points: number[], width: number) => points.map((x, n) => (n % width === 0 ? moved(x) : x));
  return { colors: move(look.colors, 4), opacities: move(look.opacities, 2) };
}
