// SPDX-License-Identifier: Apache-2.0
// Labels on unevenly spaced axes, at times of many digits (make_series.py, classes.nrrd): planes have no value between
// labels, and places are coordinates, of depths what is above 0.
import { drawn, patience, setView } from './harness.mjs';

const labelAt = (x, y, z, frame) => [0, 2, 9][(Math.floor(x / 6) + Math.floor(y / 4) + 2 * Math.floor(z / 3) + frame) % 3];

// Between samples of different labels, nearer to the one that is told.
const places = [
  { sample: [5, 3, 2], at: [123.4283, 3.3, -23] },
  { sample: [6, 4, 3], at: [123.4328, 3.7, -28] },
  { sample: [5, 4, 2], at: [123.4283, 3.7, -23] },
  { sample: [17, 11, 8], at: [123.6989, 11.3, -163] },
  { sample: [18, 12, 9], at: [123.7139, 11.7, -187] },
  { sample: [23, 15, 11], at: [123.929, 15, -300] },
];
const crossAt = ([x, y, z]) => [(x - 123.4) / 0.529, y / 15, -z / 300];

// The text of the planes that are drawn next.
const toldNext = (page, before) =>
  page
    .waitForFunction((old) => {
      const now = document.querySelector('.planes .value').textContent;
      return now !== old && now;
    }, { timeout: patience }, before)
    .then((t) => t.jsonValue());

async function values(session, page) {
  let told = await toldNext(page, '');
  for (const time of [100000.75, 100000.7]) // of one frame, and before it
    for (const { sample, at } of places) {
      const [x, y, z] = at;
      await setView(page, { time, cross: crossAt(at) });
      told = await toldNext(page, told);
      const wanted = `value = ${labelAt(...sample, 3)} at (${x} degrees, ${y}, ${z} m)`;
      session.expect(told === wanted, `at ${time} the label of the nearest sample, at its coordinates: ${wanted}`, told);
    }
  await setView(page, { cross: [0.01, 0.01, 0.01] });
  await toldNext(page, told);
}

// Colours of the planes, but for the cross-hair and names at their borders.
const colors = (page) =>
  page.evaluate(() =>
    [...document.querySelectorAll('.planes canvas')].map((canvas) => {
      const { width: w, height: h } = canvas;
      const part = [0.1 * w, 0.25 * h, 0.8 * w, 0.65 * h].map(Math.round);
      const { data } = canvas.getContext('2d').getImageData(...part);
      return new Set(new Uint32Array(data.buffer)).size;
    }),
  );

export async function uneven(session) {
  const page = await session.open('/?url=classes.bcc4#time=100000.75&planes=1');
  await drawn(page, 100000.75);
  const time = await page.evaluate(() => document.querySelector('.timeline .time').textContent);
  session.expect(time === '100000.75', 'a time has the digits that tell frames apart', time);
  await values(session, page);
  const counts = await colors(page);
  session.expect(counts.every((n) => n > 1 && n <= 3), 'planes have the colours of labels alone', counts.join());
  await page.close();
}
