// SPDX-License-Identifier: Apache-2.0
// What somebody does who looks at a series: opens a link, moves through time, plays, drops a file, turns it by touch.
import { drawn, patience, setView } from './harness.mjs';
import { longestTask } from './tasks.mjs';

// The first picture over a network of 50 ms a request; returns its page.
export async function firstPicture(session) {
  const { server, measured } = session;
  server.latency = 50;
  server.requests = [];
  const start = Date.now();
  const page = await session.open('/?url=drops.bcc4');
  await page.waitForFunction(() => window.viewer?.info, { timeout: patience });
  measured['requests to open'] = server.requests.length;
  await drawn(page);
  measured['ms to the first picture, 50 ms a request'] = Date.now() - start;
  measured['requests to the first picture'] = server.requests.length;
  measured['requests one after the other to the first picture'] = server.rounds();
  measured['kB to the first picture'] = Math.round(server.bytes() / 1000);
  server.latency = 0;
  return page;
}

export async function scrub(session, page) {
  for (const time of [3.21, 9.9, 0.07]) {
    await setView(page, { time });
    await drawn(page, time);
  }
  await page.waitForFunction(() => location.hash.includes('time=0.07'), { timeout: patience });
  session.expect(true, 'any moment is drawn, and stands in the address');
  const again = await session.open('/?url=drops.bcc4#time=5.5&turnX=40&mode=4&planes=1');
  await drawn(again, 5.5);
  const view = await again.evaluate(() => window.viewer.view);
  session.expect(view.turnX === 40 && view.mode === 4 && view.planes, 'a link comes back to its view');
  const told = () => /density|value/.test(document.querySelector('.planes .value').textContent);
  await again.waitForFunction(told, { timeout: patience });
  session.expect(true, 'planes tell the value at the cross-hair');
  await again.close();
}

// A frame's time may be from before a click that was handled late, as on a busy machine.
function lateFrames() {
  const late = 50;
  const plain = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = (act) => plain((now) => act(now - late));
}

// Plays a series of 128^3 over a network until so many moments were drawn.
export async function play(session) {
  const moments = 24;
  const page = await session.open('/?url=large.bcc4', undefined, (p) => p.evaluateOnNewDocument(lateFrames));
  await page.bringToFront();
  await drawn(page);
  session.server.latency = 50;
  await page.evaluate(() => {
    const root = document.querySelector('.bccsplat');
    window.played = { times: new Set(), stalls: 0, start: performance.now() };
    new MutationObserver((seen) => {
      window.played.times.add(root.dataset.drawn);
      const waits = (m) => m.attributeName === 'aria-busy' && m.target.getAttribute('aria-busy') === 'true';
      if (performance.now() - window.played.start > 1000) window.played.stalls += seen.filter(waits).length;
    }).observe(root, { attributes: true, subtree: true, attributeFilter: ['data-drawn', 'aria-busy'] });
  });
  const longest = await longestTask(page, async () => {
    await page.click('.play');
    await page.waitForFunction((n) => window.played.times.size >= n, { timeout: patience }, moments);
    await page.click('.play');
  });
  const { seconds, stalls } = await page.evaluate(() => ({
    seconds: (performance.now() - window.played.start) / 1000,
    stalls: window.played.stalls,
  }));
  session.server.latency = 0;
  session.expect(true, 'it plays', `${moments} moments of 128^3 in ${seconds.toFixed(1)} s`);
  session.measured['stalls after one second of play'] = stalls;
  if (longest !== undefined) session.measured['longest main-thread task while playing 128^3, ms of CPU'] = longest;
  await page.close();
}

// Planes are those of the picture: of its level, in its colours.
export async function planes(session) {
  const page = await session.open('/?url=levels.bcc4#time=4.3&planes=1&zoom=0.1');
  const told = (other = '') =>
    page
      .waitForFunction((before) => {
        const now = document.querySelector('.planes .value').textContent;
        return now !== before && now;
      }, { timeout: patience }, other)
      .then((t) => t.jsonValue(), () => '');
  const coarse = await told();
  await setView(page, { zoom: 8 });
  const fine = await told(coarse);
  session.expect(fine !== '', 'the value at the cross-hair is of the level that is drawn', `${coarse}; ${fine}`);
  const colors = () => page.evaluate(() => document.querySelector('.planes canvas').toDataURL());
  const before = await colors();
  await setView(page, { window: [0.1, 0.2] });
  session.expect((await colors()) !== before, 'planes have the colours of the picture');
  await page.close();
}

// Along a periodic axis the domain goes on from the last sample to the first.
export async function round(session) {
  const page = await session.open('/?url=round.bcc4#time=4.3&planes=1');
  const told = await page.waitForFunction(
    () => /at \(.*\)/.exec(document.querySelector('.planes .value').textContent)?.[0],
    { timeout: patience },
  );
  const text = await told.jsonValue();
  session.expect(text.startsWith('at (24, 19.5, 15.5'), 'the middle of 48 periodic samples is at 24', text);
  await page.close();
}

// Of two files the one that was asked for last stays, with its own values.
export async function another(session) {
  const page = await session.open('/?url=drops.bcc4#window=0.25,101325.125');
  await drawn(page);
  await setView(page, { turnX: 21 });
  await page.waitForFunction(() => location.hash.includes('turnX=21'), { timeout: patience });
  const link = await page.evaluate(() => location.hash);
  session.expect(/window=0.25%2C101325.125/.test(link), 'a link has values as they are', link);
  let release;
  session.server.held = new Promise((go) => (release = go));
  const seen = await page.evaluate(() => {
    const from = (name) => new URL(name, location.href).href;
    window.viewer.openUrl(from('large.bcc4?held'));
    window.viewer.openUrl(from('drops.bcc4'));
    delete document.querySelector('.bccsplat').dataset.drawn;
    return window.viewer.view.window;
  });
  session.expect(seen === null, 'another file has colours of its own');
  await drawn(page);
  const asked = page.evaluate(() => fetch('large.bcc4?held', { headers: { Range: 'bytes=0-9' } }).then(() => {}));
  release();
  await asked;
  const width = await page.evaluate(async () => {
    for (let n = 0; n < 3; ++n) (await window.viewer.snapshot()).close();
    return window.viewer.info.dims[0];
  });
  session.expect(width === 48, 'of two files the last one stays, whichever comes last', `${width} samples along x`);
  await page.close();
}

export async function dropFile(session) {
  const page = await session.open('/');
  const input = await page.$('#file');
  await input.uploadFile(`${session.data}/drops.bcc4`);
  await drawn(page);
  session.expect(true, "a file of the user's is drawn");
  await page.close();
}
