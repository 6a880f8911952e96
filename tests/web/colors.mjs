// SPDX-License-Identifier: Apache-2.0
// Colours of pixels of planes: node colors.mjs COLORS, the module of examples/web/src/page/colors.ts.
import assert from 'node:assert/strict';
import { pathToFileURL } from 'node:url';

const { Shades } = await import(pathToFileURL(process.argv[2]).href);

// Labels from 0 to 2000, of which 1000 and 1001 have colours far apart.
const look = {
  kind: 0,
  range: [0, 2000],
  iso: 0,
  colors: [0, 0, 0, 0, 999.5, 0, 0, 0, 1000, 1, 0, 0, 1000.5, 1, 0, 0, 1001, 0, 0, 1, 2000, 0, 0, 1],
  opacities: [0, 0, 2000, 1],
};
const shades = new Shades(look, null);
const label = shades.pixels(true), quantity = shades.pixels(false);
for (const value of [0, 999, 1000, 1001, 2000]) assert.deepEqual([...label(value)], [...shades.color(value), 255]);
assert.notDeepEqual(label(1000), label(1001));
assert.deepEqual([...label(1000)], [255, 0, 0, 255]);

// Quantities are in 256 steps, the ends among them, and what is beyond has the colour of the end.
assert.deepEqual(quantity(1000), quantity(1001));
assert.deepEqual([...quantity(-5)], [...shades.color(0), 255]);
assert.deepEqual([...quantity(1e6)], [...shades.color(2000), 255]);
assert.deepEqual([...quantity(2000 / 255)], [...shades.color(2000 / 255), 255]);
console.log('labels have their own colours');
