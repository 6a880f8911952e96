// SPDX-License-Identifier: Apache-2.0
// Looks at the viewer in one browser: node browsers.mjs chromium|firefox SITE DATA. Prints a line a check and a table of
// what was measured; exits with 1 where something does not hold.
import { pathToFileURL } from 'node:url';
import { CountingServer } from './server.mjs';

const [which, site, data] = process.argv.slice(2);
const puppeteer = (await import(pathToFileURL(`${process.env.BCCSPLAT_PUPPETEER}/lib/esm/puppeteer/puppeteer-core.js`).href))
  .default;

const least = 45; // dB between a browser's picture and the tool's
const limits = {
  'requests to open': 3,
  'requests to the first picture': 6,
  'kB to the first picture': 250,
  'ms to the first picture, 50 ms a request': which === 'chromium' ? 6000 : 6000, // rasterised on the CPU, beside others
  'longest main-thread task while playing, ms': 50,
};
const measured = {};
let failures = 0;
function expect(good, what, detail = '') {
  console.log(`${good ? 'ok    ' : 'FAILED'} ${which}: ${what}${detail ? ` (${detail})` : ''}`);
  if (!good) ++failures;
}

// A viewer of a fixed size on black, without controls.
const bare = `<!doctype html><link rel="stylesheet" href="viewer.css"><style>.bccsplat{--stage: rgb(0, 0, 0) !important}</style>
<div id="v" style="width:200px;height:200px"></div><script type="module">
import { createViewer } from './viewer.mjs';
window.viewer = createViewer(document.getElementById('v'), { bare: true, url: 'drops.bcc4', view: { time: 4.3 } });
</script>`;

const chromium = {
  executablePath: '/usr/bin/chromium',
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--force-color-profile=srgb'],
};
const firefox = { browser: 'firefox', executablePath: '/usr/bin/firefox-esr', headless: false };
const browser = await puppeteer.launch(which === 'firefox' ? firefox : chromium);
const server = await new CountingServer([site, data], { '/bare.html': bare }).start();
const other = await new CountingServer([data]).start(); // of another origin

const patience = 60000;
async function open(path, size = { width: 700, height: 560 }) {
  const page = await browser.newPage();
  await page.setViewport(size);
  page.on('pageerror', (e) => expect(false, `no error in the page ${path}`, e.message));
  await page.goto(server.base + path);
  return page;
}
const drawn = (page, time) =>
  page.waitForFunction(
    (t) => {
      const at = document.querySelector('.bccsplat')?.dataset.drawn;
      return at !== undefined && (t === null || Math.abs(Number(at) - t) < 1e-9);
    },
    { timeout: patience },
    time ?? null,
  );

async function firstPicture() {
  server.latency = 50;
  server.requests = [];
  const page = await browser.newPage();
  await page.setViewport({ width: 700, height: 560 });
  await page.evaluateOnNewDocument(() => {
    window.opened = undefined;
  });
  const start = Date.now();
  await page.goto(`${server.base}/?url=drops.bcc4`);
  await page.waitForFunction(() => window.viewer?.info, { timeout: patience });
  measured['requests to open'] = server.requests.length;
  await drawn(page);
  measured['ms to the first picture, 50 ms a request'] = Date.now() - start;
  measured['requests to the first picture'] = server.requests.length;
  measured['kB to the first picture'] = Math.round(server.bytes() / 1000);
  server.latency = 0;
  return page;
}

// Decibels between what the viewer shows and a picture of the tool.
function compare(page, expected, view) {
  return page.evaluate(
    async (file, wanted) => {
      Object.assign(window.viewer.view, wanted);
      window.viewer.refresh();
      await new Promise((go) => setTimeout(go, 300));
      const pixels = (image) => {
        const canvas = new OffscreenCanvas(image.width, image.height);
        const c = canvas.getContext('2d');
        c.drawImage(image, 0, 0);
        return c.getImageData(0, 0, image.width, image.height).data;
      };
      const seen = pixels(await window.viewer.snapshot());
      const told = pixels(await createImageBitmap(await (await fetch(file)).blob(), { colorSpaceConversion: 'none' }));
      if (seen.length !== told.length) return -1;
      let sum = 0, lit = 0;
      for (let n = 0; n < seen.length; ++n) {
        sum += (seen[n] - told[n]) ** 2;
        if (told[n] > 8 && n % 4 < 3) ++lit;
      }
      return lit < 1000 ? -2 : 10 * Math.log10((255 * 255) / Math.max(sum / (seen.length * 0.75), 1e-9));
    },
    expected,
    view,
  );
}

async function pictures() {
  const page = await open('/bare.html', { width: 300, height: 300 });
  await drawn(page);
  const cases = {
    composite: {},
    surface: { mode: 2, iso: 0.4 },
    maximum: { mode: 4, iso: null },
    xray: { mode: 3 },
    turned: { mode: 1, perspective: true, turnX: 35, turnY: -50, zoom: 1.5 },
  };
  for (const [name, view] of Object.entries(cases)) {
    const db = await compare(page, `${name}.png`, view);
    measured[`dB to the tool's picture, ${name}`] = Number(db.toFixed(1));
    expect(db >= least, `${name} is the tool's picture`, `${db.toFixed(1)} dB`);
  }
  await page.close();
}

async function scrub(page) {
  for (const time of [3.21, 9.9, 0.07]) {
    await page.evaluate((t) => {
      window.viewer.view.time = t;
      window.viewer.refresh();
    }, time);
    await drawn(page, time);
  }
  await page.waitForFunction(() => location.hash.includes('time=0.07'), { timeout: patience });
  expect(true, 'any moment is drawn, and stands in the address');
  const again = await open(`/?url=drops.bcc4#time=5.5&turnX=40&mode=4&planes=1`);
  await drawn(again, 5.5);
  const view = await again.evaluate(() => window.viewer.view);
  expect(view.turnX === 40 && view.mode === 4 && view.planes, 'a link comes back to its view');
  await again.waitForFunction(() => /density|value/.test(document.querySelector('.planes .value').textContent), {
    timeout: patience,
  });
  expect(true, 'planes tell the value at the cross-hair');
  await again.close();
}

async function play(page) {
  await page.evaluate(() => {
    window.tasks = [];
    if (PerformanceObserver.supportedEntryTypes.includes('longtask'))
      new PerformanceObserver((list) => window.tasks.push(...list.getEntries().map((e) => e.duration))).observe({
        entryTypes: ['longtask'],
      });
    window.times = new Set();
    new MutationObserver(() => window.times.add(document.querySelector('.bccsplat').dataset.drawn)).observe(
      document.querySelector('.bccsplat'),
      { attributes: true },
    );
    document.querySelector('.play').click();
  });
  await new Promise((go) => setTimeout(go, 4000));
  const { moments, longest, supported } = await page.evaluate(() => ({
    moments: window.times.size,
    longest: Math.max(0, ...window.tasks),
    supported: PerformanceObserver.supportedEntryTypes.includes('longtask'),
  }));
  await page.click('.play');
  measured['moments drawn in 4 s of play'] = moments;
  if (supported) measured['longest main-thread task while playing, ms'] = Math.round(longest);
  expect(moments >= 5, 'it plays', `${moments} moments`);
}

async function dropFile() {
  const page = await open('/');
  const input = await page.$('#file');
  await input.uploadFile(`${data}/drops.bcc4`);
  await drawn(page);
  expect(true, "a file of the user's is drawn");
  await page.close();
}

async function failing(path, sentence, what) {
  const page = await browser.newPage();
  await page.goto(server.base + path);
  const text = await page
    .waitForFunction(() => document.querySelector('.notice.failed')?.textContent, { timeout: patience })
    .then((t) => t.jsonValue(), () => 'no text at all');
  expect(sentence.test(text), what, text.slice(0, 90));
  await page.close();
}

async function errors() {
  const of = (url) => `/?url=${encodeURIComponent(url)}`;
  await failing(of(`${server.base}/drops.bcc4?ranges=no`), /does not answer range requests/, 'no ranges: says so');
  await failing(of(`${other.base}/drops.bcc4`), /does not let other pages read/, 'CORS: says so');
  await failing(of('nothing.bcc4'), /There is no file at/, 'no file: says so');
  await failing(of(`${server.base}/drops.bcc4?status=403`), /does not give/, 'forbidden: says so');
  await failing(of('cut.bcc4'), /cannot be shown/, 'a cut file: says so');
  await failing(of('http://127.0.0.1:9/x.bcc4'), /cannot be reached/, 'no server: says so');
}

const page = await firstPicture();
await pictures();
await scrub(page);
await play(page);
await dropFile();
await errors();
await browser.close();
server.stop();
other.stop();

console.log(`\n${which.padEnd(48)} measured    limit`);
for (const [name, value] of Object.entries(measured)) {
  const limit = limits[name];
  console.log(`${name.padEnd(48)} ${String(value).padStart(8)} ${String(limit ?? '').padStart(8)}`);
  if (limit !== undefined && value > limit) expect(false, `${name}: at most ${limit}`);
}
process.exit(failures ? 1 : 0);
