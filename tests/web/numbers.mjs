// SPDX-License-Identifier: Apache-2.0
// Numbers as the page writes them: node numbers.mjs FORMAT, the module of examples/web/src/page/format.ts.
import assert from 'node:assert/strict';
import { pathToFileURL } from 'node:url';

const { closest, number, timeText, withUnit } = await import(pathToFileURL(process.argv[2]).href);

// Values of a field are short.
for (const [x, text] of [[0, '0'], [0.123456, '0.1235'], [-101325.125, '-101300'], [1234567, '1.23e+6'], [1.2345e-5, '1.23e-5'], [NaN, '–']])
  assert.equal(number(x), text);

// Places and times are told to a hundredth of what neighbours differ by.
for (const [x, apart, text] of [
  [12345.6, 0.1, '12345.6'],
  [123.456, 0.001, '123.456'],
  [2020.25, 0.25, '2020.25'],
  [2020.125, 0.125, '2020.125'],
  [100001, 1, '100001'],
  [-100001, 1, '-100001'],
  [2451545.25, 0.25, '2451545.25'],
  [1700000060, 60, '1700000060'],
  [3.15576e16, 1e13, '3.15576e+16'],
  [1.23456e-7, 1e-10, '1.23456e-7'],
  [0.1 + 0.2, 1e-20, '0.3'],
  [4.32178, 0.5, '4.322'],
  [-3.6e-15, 0.1, '0'],
  [0, 1, '0'],
])
  assert.equal(number(x, apart), text);
for (const [x, apart] of [[12345.6, 0.1], [2020, 1 / 12], [1e6, 0.003], [7e-6, 1e-9]])
  assert.notEqual(number(x, apart), number(x + apart, apart));
assert.equal(withUnit(100001, 's', 1), '100001 s');

assert.equal(closest([0, 10, 12.5, 30]), 2.5);
assert.equal(closest([30, 12.5, 10]), 2.5);
assert.equal(closest([7]), 0);
assert.equal(closest([]), 0);
assert.equal(timeText(2020.25, { times: [2020, 2020.25, 2021], timeUnit: 'years' }), '2020.25 years');
assert.equal(timeText(1, { times: [1], timeUnit: '' }), '1');
console.log('numbers are told apart');
