// SPDX-License-Identifier: Apache-2.0
// How long the page's main thread was busy at a stretch, by Chromium's trace: in its own time, in which other processes of
// a busy machine do not count.

const named = (events, name) => events.filter((e) => e.name === name);

// Milliseconds of the longest task of the page's thread while the body runs; undefined where the browser has no traces.
export async function longestTask(page, body) {
  if (!page.tracing || page.browser().process()?.spawnfile.includes('firefox')) {
    await body();
    return undefined;
  }
  await page.tracing.start({ categories: ['toplevel', '__metadata', 'disabled-by-default-devtools.timeline'] });
  await body();
  const { traceEvents } = JSON.parse(Buffer.from(await page.tracing.stop()).toString());
  return longestIn(traceEvents);
}

// The thread is the one that most tasks of a main thread of a renderer ran on: the page's that plays.
function longestIn(events) {
  const mains = named(events, 'thread_name').filter((e) => e.args.name === 'CrRendererMain');
  const tasks = mains.map((m) =>
    events.filter((e) => e.pid === m.pid && e.tid === m.tid && /RunTask$/.test(e.name) && e.tdur !== undefined),
  );
  const busiest = tasks.sort((a, b) => b.length - a.length)[0] ?? [];
  if (busiest.length === 0) throw new Error('the trace has no tasks of a main thread');
  return Math.round(Math.max(...busiest.map((e) => e.tdur)) / 100) / 10;
}
