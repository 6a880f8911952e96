// SPDX-License-Identifier: Apache-2.0
// Numbers as people read them.
import type { VolumeInfo } from '../protocol';

const most = 15; // digits; what is behind is rounding

// apart: what neighbours differ by, a hundredth of which is told; 0: a few digits are enough.
export function number(x: number, apart = 0): string {
  if (!Number.isFinite(x)) return '–';
  const size = Math.abs(x);
  if (x === 0 || size < apart / 1000) return '0';
  const extreme = size >= 1e6 || size < 1e-4;
  const few = extreme ? 3 : 4;
  const digits = apart > 0 ? Math.min(most, Math.max(few, Math.ceil(Math.log10(size / apart)) + 2)) : few;
  const short = Number(x.toPrecision(digits));
  const written = String(short), power = short.toExponential();
  return extreme && power.length <= written.length ? power : written;
}

export function withUnit(x: number, unit: string, apart = 0): string {
  return unit ? `${number(x, apart)} ${unit}` : number(x, apart);
}

// The smallest difference of neighbours; 0: there are none.
export function closest(places: number[]): number {
  return places.reduce((least, x, n) => (n > 0 ? Math.min(least || Infinity, Math.abs(x - places[n - 1])) : 0), 0);
}

export function timeText(time: number, info: VolumeInfo): string {
  return withUnit(time, info.timeUnit, closest(info.times));
}

export function bytes(n: number): string {
  if (n < 1e6) return `${Math.round(n / 1e3)} kB`;
  return `${(n / 1e6).toFixed(n < 1e7 ? 1 : 0)} MB`;
}

// The largest of 1, 2, 5 times a power of ten that is at most x.
export function roundLength(x: number): number {
  const power = 10 ** Math.floor(Math.log10(x));
  const part = x / power;
  return (part >= 5 ? 5 : part >= 2 ? 2 : 1) * power;
}
