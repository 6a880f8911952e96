// SPDX-License-Identifier: Apache-2.0
// Numbers as people read them.

const digits = 4;

export function number(x: number): string {
  if (!Number.isFinite(x)) return '–';
  if (x === 0) return '0';
  const size = Math.abs(x);
  if (size >= 1e6 || size < 1e-4) return x.toExponential(2);
  return String(Number(x.toPrecision(digits)));
}

export function withUnit(x: number, unit: string): string {
  return unit ? `${number(x)} ${unit}` : number(x);
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
