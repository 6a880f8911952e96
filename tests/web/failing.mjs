// SPDX-License-Identifier: Apache-2.0
// What may go wrong: each says its sentence, and what can come back does.
import { drawn, patience, setView } from './harness.mjs';

const toldError = (page) =>
  page
    .waitForFunction(() => document.querySelector('.notice.failed')?.textContent, { timeout: patience })
    .then((t) => t.jsonValue(), () => 'no text at all');

async function failing(session, path, sentence, what, browser = session.browser) {
  const page = await browser.newPage();
  await page.goto(session.server.base + path);
  const text = await toldError(page);
  session.expect(sentence.test(text), what, text.slice(0, 100));
  await page.close();
}

export async function errors(session) {
  const { server, other } = session;
  const of = (url) => `/?url=${encodeURIComponent(url)}`;
  const says = (url, sentence, what) => failing(session, of(url), sentence, `${what}: says so`);
  await says(`${server.base}/drops.bcc4?ranges=no`, /does not answer range requests/, 'no ranges');
  await says(`${other.base}/drops.bcc4`, /does not let other pages read/, 'CORS');
  await says('nothing.bcc4', /There is no file at/, 'no file');
  await says(`${server.base}/drops.bcc4?status=403`, /does not give/, 'forbidden');
  await says(`${server.base}/drops.bcc4?status=500`, /answered with status 500/, 'a server that fails');
  await says('cut.bcc4', /cannot be shown/, 'a cut file');
  await says('damaged.bcc4', /cannot be shown/, 'a damaged file');
  await says('torn.bcc4', /cannot be shown/, 'damaged values');
  await says('index.html', /cannot be shown/, 'no volume at all');
  await says('http://127.0.0.1:9/x.bcc4', /cannot be reached/, 'no server');
  const browser = await session.startWithoutWebgl();
  await failing(session, of('drops.bcc4'), /gives no WebGL2/, 'no WebGL2: says so', browser);
  await browser.close();
}

// A server that goes away while somebody looks, and is there again.
export async function lostServer(session) {
  const page = await session.open('/?url=large.bcc4');
  await drawn(page);
  session.server.refuses = true;
  await setView(page, { time: 5 });
  const text = await toldError(page);
  session.expect(/cannot be reached/.test(text), 'a server that is gone: says so', text.slice(0, 100));
  session.server.refuses = false;
  await setView(page, { time: 4.5 });
  await drawn(page, 4.5);
  const hidden = await page.evaluate(() => document.querySelector('.notice').hidden);
  session.expect(hidden, 'a server that is back: the picture is, too');
  await page.close();
}

// A film whose file is left ends, and the viewer draws the next one.
export async function leftFilm(session) {
  const page = await session.open('/bare.html?url=large.bcc4&time=0', { width: 300, height: 300 });
  await drawn(page);
  await page.evaluate(() => {
    void window.viewer.saveFilm();
    window.viewer.openUrl(new URL('drops.bcc4', location.href).href);
    delete document.querySelector('.bccsplat').dataset.drawn;
  });
  const next = await drawn(page).then(() => true, () => false);
  session.expect(next, 'a film whose file is left ends, and the next one is drawn');
  await page.close();
}

// A film that a browser does not record is an error, after which the viewer draws as before.
export async function brokenFilm(session) {
  const page = await session.open('/bare.html?url=drops.bcc4&time=0', { width: 300, height: 300 });
  await drawn(page);
  const text = await page.evaluate(() => {
    window.MediaRecorder = class {
      constructor() {
        throw new Error('nothing is recorded');
      }
      static isTypeSupported = () => false;
    };
    return window.viewer.saveFilm().then(() => '', (e) => e.message);
  });
  await setView(page, { time: 3 });
  const next = await drawn(page, 3).then(() => true, () => false);
  session.expect(next && text === 'nothing is recorded', 'after a film that fails the next moment is drawn', text);
  await page.close();
}

// Keeps the contexts that the page and its workers make, and lets go of one when asked to on a channel.
const patch = `
for (const kind of [globalThis.OffscreenCanvas, globalThis.HTMLCanvasElement]) {
  if (!kind) continue;
  const made = kind.prototype.getContext;
  kind.prototype.getContext = function (...given) {
    const context = made.apply(this, given);
    if (given[0] === 'webgl2' && context) globalThis.kept = context.getExtension('WEBGL_lose_context');
    return context;
  };
}
new BroadcastChannel('context').onmessage = (e) => globalThis.kept?.[e.data]();`;

function patchContexts(text) {
  new Function(text)();
  const Plain = window.Worker;
  window.Worker = class extends Plain {
    constructor(source, options) {
      const link = (s) => URL.createObjectURL(new Blob([s], { type: 'text/javascript' }));
      super(link(`import ${JSON.stringify(link(text))}; import ${JSON.stringify(String(source))};`), options);
    }
  };
}

export async function lostContext(session) {
  const page = await session.open('/?url=drops.bcc4', undefined, (p) => p.evaluateOnNewDocument(patchContexts, patch));
  await drawn(page);
  const tell = (what) => page.evaluate((name) => new BroadcastChannel('context').postMessage(name), what);
  await tell('loseContext');
  const text = await toldError(page);
  session.expect(/lost its graphics context/.test(text), 'a lost context: says so', text.slice(0, 100));
  await tell('restoreContext');
  await drawn(page);
  const again = await page.evaluate(async () => {
    const image = await window.viewer.snapshot();
    const c = new OffscreenCanvas(image.width, image.height).getContext('2d');
    c.drawImage(image, 0, 0);
    const { data } = c.getImageData(0, 0, image.width, image.height);
    return { shades: new Set(new Uint32Array(data.buffer)).size, hidden: document.querySelector('.notice').hidden };
  });
  session.expect(again.shades > 100 && again.hidden, 'a new context: the picture is back', `${again.shades} colours`);
  await page.close();
}
