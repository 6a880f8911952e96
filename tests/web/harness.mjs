// SPDX-License-Identifier: Apache-2.0
// One browser with the servers that it is tried against: opens pages, waits for conditions, keeps what was measured, and
// compares that with its limits in the end. Nothing here waits for a time: a machine that is busy is slower, not wrong.
import { pathToFileURL } from 'node:url';
import { CountingServer } from './server.mjs';

const library = `${process.env.BCCSPLAT_PUPPETEER}/lib/esm/puppeteer/puppeteer-core.js`;
const puppeteer = (await import(pathToFileURL(library).href)).default;

export const patience = 120000; // milliseconds that a condition may take to hold
const chromium = {
  executablePath: '/usr/bin/chromium',
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--force-color-profile=srgb'],
};
const firefox = { browser: 'firefox', executablePath: '/usr/bin/firefox-esr', headless: false };
const withoutWebgl = {
  chromium: { ...chromium, args: ['--no-sandbox', '--disable-gpu', '--disable-software-rasterizer'] },
  firefox: { ...firefox, extraPrefsFirefox: { 'webgl.disabled': true } },
};

// A viewer of a fixed size on black, without controls; ?url= names its file, ?time= its moment.
const bare = `<!doctype html><link rel="stylesheet" href="viewer.css"><style>.bccsplat{--stage: rgb(0, 0, 0) !important}</style>
<div id="v" style="width:200px;height:200px"></div><script type="module">
import { createViewer } from './viewer.mjs';
const given = new URLSearchParams(location.search);
window.viewer = createViewer(document.getElementById('v'),
  { bare: true, url: given.get('url'), view: { time: Number(given.get('time')) } });
</script>`;

export class Session {
  measured = {};
  failures = 0;

  constructor(which, site, data) {
    Object.assign(this, { which, site, data });
  }

  launch(options) {
    return puppeteer.launch({ protocolTimeout: 2 * patience, timeout: patience, ...options });
  }
  async start() {
    this.browser = await this.launch(this.which === 'firefox' ? firefox : chromium);
    this.server = await new CountingServer([this.site, this.data], { '/bare.html': bare }).start();
    this.other = await new CountingServer([this.data]).start(); // of another origin
    return this;
  }
  // The same browser where it gives pages no WebGL.
  startWithoutWebgl() {
    return this.launch(withoutWebgl[this.which]);
  }
  async end() {
    await this.browser.close();
    this.server.stop();
    this.other.stop();
  }

  expect(good, what, detail = '') {
    console.log(`${good ? 'ok    ' : 'FAILED'} ${this.which}: ${what}${detail ? ` (${detail})` : ''}`);
    if (!good) ++this.failures;
  }

  // A part that cannot go on is a failure, and the next one begins.
  async part(what, ...given) {
    try {
      return await what(this, ...given);
    } catch (e) {
      this.expect(false, what.name, e.stack);
    }
  }

  // prepare: awaited with the page before it loads anything.
  async open(path, size = { width: 700, height: 560 }, prepare = () => {}) {
    const page = await this.browser.newPage();
    page.setDefaultTimeout(patience);
    await page.setViewport(size);
    page.on('pageerror', (e) => this.expect(false, `no error in the page ${path}`, e.message));
    await prepare(page);
    await page.goto(this.server.base + path);
    return page;
  }

  // Prints what was measured, and fails where that is over its limit.
  table(limits) {
    console.log(`\n${this.which.padEnd(56)} measured    limit`);
    for (const [name, value] of Object.entries(this.measured)) {
      const limit = limits[name];
      console.log(`${name.padEnd(56)} ${String(value).padStart(8)} ${String(limit ?? '').padStart(8)}`);
      if (limit !== undefined && !(value <= limit)) this.expect(false, `${name}: at most ${limit}`);
    }
  }
}

// Resolves when a picture of a moment, or of any, is there.
export const drawn = (page, time) =>
  page.waitForFunction(
    (t) => {
      const at = document.querySelector('.bccsplat')?.dataset.drawn;
      return at !== undefined && (t === null || Math.abs(Number(at) - t) < 1e-9);
    },
    { timeout: patience },
    time ?? null,
  );

// Changes the view; resolves when the engine was told.
export const setView = (page, view) =>
  page.evaluate(async (wanted) => {
    Object.assign(window.viewer.view, wanted);
    window.viewer.refresh();
    for (let n = 0; n < 2; ++n) await new Promise((go) => requestAnimationFrame(go));
  }, view);
