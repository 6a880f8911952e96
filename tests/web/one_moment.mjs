// SPDX-License-Identifier: Apache-2.0
// One moment of each kind of file against the tool's picture: node one_moment.mjs chromium|firefox SITE DATA. Exits with 1
// where they differ.
import { Session } from './harness.mjs';
import { pictures } from './pictures.mjs';

const session = await new Session(...process.argv.slice(2)).start();
for (const file of ['drops', 'waves']) await session.part(pictures, file, 4.3, ['composite']);
await session.end();
process.exit(session.failures ? 1 : 0);
