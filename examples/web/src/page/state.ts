// SPDX-License-Identifier: Apache-2.0
// The view as it starts, and as a link holds it: what differs from the start, behind the hash.
import type { View } from '../protocol';

export function startView(): View {
  return {
    time: 0,
    channel: 0,
    mode: 1,
    look: 0,
    iso: null,
    window: null,
    opacity: 1,
    shading: true,
    perspective: false,
    turnX: 20,
    turnY: 30,
    zoom: 1,
    panX: 0,
    panY: 0,
    clip: [0, 0, 0, 1, 1, 1],
    cross: [0.5, 0.5, 0.5],
    planes: false,
  };
}

const digits = 15; // times and values are of any size; what is behind is rounding
const short = (x: number) => String(Number(x.toPrecision(digits)));

function written(value: View[keyof View]): string {
  if (Array.isArray(value)) return value.map(short).join(',');
  if (typeof value === 'boolean') return value ? '1' : '0';
  return value === null ? '' : short(value);
}

export function toHash(view: View): string {
  const start = startView();
  const out = new URLSearchParams();
  for (const key of Object.keys(start) as (keyof View)[])
    if (written(view[key]) !== written(start[key])) out.set(key, written(view[key]));
  return out.toString();
}

// Returns the view that a hash holds; what it cannot be is left as it starts.
export function fromHash(hash: string): View {
  const view = startView();
  const given = new URLSearchParams(hash.replace(/^#/, ''));
  const put = <K extends keyof View>(key: K, value: View[K]) => (view[key] = value);
  for (const key of Object.keys(view) as (keyof View)[]) {
    const text = given.get(key);
    if (!text) continue;
    const numbers = text.split(',').map(Number);
    if (numbers.some((x) => !Number.isFinite(x))) continue;
    const now = view[key];
    const count = Array.isArray(now) ? now.length : key === 'window' ? 2 : 1;
    if (numbers.length !== count) continue;
    if (count > 1) put(key, numbers as never);
    else if (typeof now === 'boolean') put(key, (numbers[0] !== 0) as never);
    else put(key, numbers[0] as never);
  }
  return view;
}
