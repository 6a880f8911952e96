// SPDX-License-Identifier: Apache-2.0
// Looks at the viewer in one browser: node browsers.mjs chromium|firefox SITE DATA. Prints a line a check and a table of
// what was measured; exits with 1 where something does not hold.
import { brokenFilm, errors, leftFilm, lostContext, lostServer } from './failing.mjs';
import { Session } from './harness.mjs';
import { another, dropFile, firstPicture, planes, play, round, scrub } from './looking.mjs';
import { pictures } from './pictures.mjs';
import { onAPhone } from './touch.mjs';
import { uneven } from './uneven.mjs';

const limits = {
  'requests to open': 3,
  'requests to the first picture': 6,
  'requests one after the other to the first picture': 4,
  'kB to the first picture': 250,
  'ms to the first picture, 50 ms a request': 30000, // rasterised on the CPU, beside others
  'stalls after one second of play': 0,
  'longest main-thread task while playing 128^3, ms of CPU': 50,
};

const session = await new Session(...process.argv.slice(2)).start();
const page = await session.part(firstPicture);
if (page) await session.part(scrub, page);
await page?.close();
await session.part(pictures, 'drops', 4.3, ['composite', 'surface', 'maximum', 'xray', 'turned']);
await session.part(pictures, 'waves', 4.3, ['composite']);
await session.part(pictures, 'round', 4.3, ['composite', 'cut']);
for (const part of [play, planes, round, uneven, another, dropFile, onAPhone, lostContext, lostServer, leftFilm, brokenFilm, errors]) await session.part(part);
await session.end();
session.table(limits);
process.exit(session.failures ? 1 : 0);
