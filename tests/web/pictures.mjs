// SPDX-License-Identifier: Apache-2.0
// Pictures of the viewer against those of the tool's CPU drawers.
import { drawn, setView } from './harness.mjs';

const least = 45; // dB between the two

// Decibels between what the viewer shows and a picture of the tool; below 0: there is none to compare.
function compare(page, file) {
  return page.evaluate(async (name) => {
    const pixels = (image) => {
      const canvas = new OffscreenCanvas(image.width, image.height);
      const c = canvas.getContext('2d');
      c.drawImage(image, 0, 0);
      return c.getImageData(0, 0, image.width, image.height).data;
    };
    const seen = pixels(await window.viewer.snapshot());
    const told = pixels(await createImageBitmap(await (await fetch(name)).blob(), { colorSpaceConversion: 'none' }));
    if (seen.length !== told.length) return -1;
    let sum = 0, lit = 0;
    for (let n = 0; n < seen.length; ++n) {
      sum += (seen[n] - told[n]) ** 2;
      if (told[n] > 8 && n % 4 < 3) ++lit;
    }
    return lit < 1000 ? -2 : 10 * Math.log10((255 * 255) / Math.max(sum / (seen.length * 0.75), 1e-9));
  }, file);
}

const cases = {
  composite: {},
  surface: { mode: 2, iso: 0.4 },
  maximum: { mode: 4, iso: null },
  xray: { mode: 3 },
  cut: { clip: [0, 0, 0, 1, 1, 0.5] },
  turned: { mode: 1, perspective: true, turnX: 35, turnY: -50, zoom: 1.5 },
};

// NAME.bcc4 against NAME-CASE.png, at the time of both.
export async function pictures(session, name, time, which) {
  const page = await session.open(`/bare.html?url=${name}.bcc4&time=${time}`, { width: 300, height: 300 });
  await drawn(page);
  for (const of of which) {
    await setView(page, cases[of]);
    const db = await compare(page, `${name}-${of}.png`);
    session.measured[`dB to the tool's picture, ${name} ${of}`] = Number(db.toFixed(1));
    session.expect(db >= least, `${of} of ${name} is the tool's picture`, `${db.toFixed(1)} dB`);
  }
  await page.close();
}
