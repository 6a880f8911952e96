// SPDX-License-Identifier: Apache-2.0
// A phone: its layout, and one or two fingers on the picture.
import { drawn, patience } from './harness.mjs';

const phone = { width: 390, height: 780 };

// Moves fingers along lines of [from, to], in steps, from down to up.
async function strokes(page, lines) {
  const steps = 4;
  const at = ([from, to], n) => [0, 1].map((a) => from[a] + ((to[a] - from[a]) * n) / steps);
  const fingers = [];
  for (const line of lines) fingers.push(await page.touchscreen.touchStart(...at(line, 0)));
  for (let n = 1; n <= steps; ++n) for (const [i, line] of lines.entries()) await fingers[i].move(...at(line, n));
  for (const finger of fingers) await finger.end();
}

const viewOf = (page) => page.evaluate(() => structuredClone(window.viewer.view));

async function fingers(session, page) {
  const middle = await page.evaluate(() => {
    const r = document.querySelector('.stage').getBoundingClientRect();
    return [Math.round(r.x + r.width / 2), Math.round(r.y + r.height / 2)];
  });
  const from = (dx, dy) => [middle[0] + dx, middle[1] + dy];
  const start = await viewOf(page);
  await strokes(page, [[from(-40, 0), from(40, 0)]]);
  const turned = await viewOf(page);
  session.expect(turned.turnY !== start.turnY && turned.zoom === 1, 'one finger turns', `by ${turned.turnY - start.turnY} degrees`);
  await strokes(page, [[from(-30, 0), from(-90, 0)], [from(30, 0), from(90, 0)]]);
  const pinched = await viewOf(page);
  session.expect(
    pinched.zoom > 2.5 && pinched.zoom < 3.5 && pinched.turnY === turned.turnY,
    'two fingers that spread enlarge',
    `${pinched.zoom.toFixed(2)} times`,
  );
  await strokes(page, [[from(-40, 0), from(-40, 60)], [from(40, 0), from(40, 60)]]);
  const moved = await viewOf(page);
  session.expect(
    moved.panY < pinched.panY - 0.05 && Math.abs(moved.zoom / pinched.zoom - 1) < 0.05,
    'two fingers side by side move it',
    `by ${(moved.panY - pinched.panY).toFixed(3)} of its height`,
  );
}

async function layout(session, page) {
  const seen = await page.evaluate(() => {
    const box = (name) => document.querySelector(name).getBoundingClientRect();
    const stage = box('.stage'), play = box('.play');
    const small = [...document.querySelectorAll('button, select, input[type=range]')].filter((e) => {
      const r = e.getBoundingClientRect();
      return r.height > 0 && r.height < 32;
    });
    return {
      sideways: document.documentElement.scrollWidth - innerWidth,
      stage: (stage.width * stage.height) / (innerWidth * innerHeight),
      playVisible: play.bottom <= innerHeight && play.right <= innerWidth && play.width >= 40,
      small: small.map((e) => e.className || e.id || e.tagName).join(' '),
    };
  });
  session.expect(seen.sideways <= 0, 'a phone shows the page without scrolling sideways', `${seen.sideways} pixels over`);
  session.expect(seen.stage >= 0.5, 'the volume has half of a phone or more', `${Math.round(100 * seen.stage)} %`);
  session.expect(seen.playVisible, 'play is within reach');
  session.expect(seen.small === '', 'controls are large enough for fingers', seen.small);
}

export async function onAPhone(session) {
  const page = await session.open('/?url=drops.bcc4', phone);
  await drawn(page);
  await layout(session, page);
  await fingers(session, page);
  await page.waitForFunction(() => location.hash.includes('zoom'), { timeout: patience });
  await page.close();
}
