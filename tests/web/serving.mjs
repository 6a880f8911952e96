// SPDX-License-Identifier: Apache-2.0
// The example's server by itself: ranges, who is answered, and that no request ends it: node serving.mjs SCRATCH
import assert from 'node:assert/strict';
import { mkdirSync, writeFileSync } from 'node:fs';
import { connect } from 'node:net';
import { join } from 'node:path';
import { CountingServer } from './server.mjs';

const [scratch] = process.argv.slice(2);
const whole = Buffer.from(Array.from({ length: 1000 }, (_, n) => n % 251));
mkdirSync(join(scratch, 'site'));
mkdirSync(join(scratch, 'site-secret'));
writeFileSync(join(scratch, 'site/file.bcc4'), whole);
writeFileSync(join(scratch, 'site/empty'), '');
writeFileSync(join(scratch, 'site-secret/file'), 'no');
const server = await new CountingServer([join(scratch, 'site')]).start();
const port = new URL(server.base).port;

// What is answered to these bytes, up to the end of the connection, or in a second.
function raw(request) {
  return new Promise((done, fail) => {
    const socket = connect(port, '127.0.0.1', () => socket.write(request, 'latin1'));
    socket.setTimeout(1000, () => socket.destroy());
    const parts = [];
    socket.on('data', (part) => parts.push(part)).on('error', fail);
    socket.on('close', () => done(Buffer.concat(parts)));
  });
}
async function ask(path, headers = {}, method = 'GET') {
  const lines = Object.entries({ Host: `127.0.0.1:${port}`, Connection: 'close', ...headers }).map(([name, is]) => `${name}: ${is}\r\n`);
  const told = await raw(`${method} ${path} HTTP/1.1\r\n${lines.join('')}\r\n`);
  const end = told.indexOf('\r\n\r\n');
  const head = told.subarray(0, end).toString('latin1');
  const range = /^content-range: (.*)$/im.exec(head)?.[1].trim();
  return { status: Number(head.split(' ')[1]), length: Number(/^content-length: (\d+)/im.exec(head)?.[1]), range, body: told.subarray(end + 4) };
}

for (const [asked, first, last] of [['10-29', 10, 29], ['-7', 993, 999], ['990-2000', 990, 999], ['5-', 5, 999], [`-${10n ** 25n}`, 0, 999]]) {
  const { status, body, range } = await ask('/file.bcc4', { Range: `bytes=${asked}` });
  assert.deepEqual([status, range], [206, `bytes ${first}-${last}/1000`], asked);
  assert.deepEqual(body, whole.subarray(first, last + 1), asked);
}
for (const asked of ['1000-', '-0', `${10n ** 25n}-`, `${'9'.repeat(400)}-`]) {
  const { status, range } = await ask('/file.bcc4', { Range: `bytes=${asked}` });
  assert.deepEqual([status, range], [416, 'bytes */1000'], asked);
}
for (const asked of ['bytes=abc-10', 'bytes=0-1,5-6', 'bytes=5-2', 'bytes=-', 'bytes=', 'lines=1-5', '1-5']) {
  const { status, body, range } = await ask('/file.bcc4', { Range: asked });
  assert.deepEqual([status, body, range], [200, whole, undefined], asked);
}
assert.equal((await ask('/file.bcc4', { Range: 'bytes=1-5', 'If-Range': '"a"' })).status, 200);
const head = await ask('/file.bcc4', { Range: 'bytes=1-5' }, 'HEAD');
assert.deepEqual([head.status, head.length, head.body.length], [200, 1000, 0]);
assert.deepEqual((await ask('/empty')).status, 200);
assert.equal((await ask('/file.bcc4', {}, 'POST')).status, 405);
for (const path of ['/../site-secret/file', '/%2e%2e/site-secret/file', '/..%2fsite-secret/file', '/%2e%2e-secret/file', '/', '/nothing', '/%00']) {
  assert.equal((await ask(path)).status, 404, path);
}
for (const host of [`localhost:${port}`, `LocalHost:${port}`]) assert.equal((await ask('/file.bcc4', { Host: host })).status, 200, host);
for (const host of ['evil.example', `evil.example:${port}`, 'localhost', '127.0.0.1', `localhost:${port}0`, `127.0.0.1.evil.example:${port}`]) {
  const { status, body } = await ask('/file.bcc4', { Host: host });
  assert.equal(status, 403, host);
  assert.ok(body.length < 100, host);
}
for (const path of ['?x', '*', '%', '/%', '/%zz', '//', 'http://[', '//[', '/\\..\\..', '@', ':', '/?%']) {
  const { status } = await ask(path);
  assert.ok([200, 400, 404].includes(status), `${path}: ${status}`);
  assert.equal((await ask('/file.bcc4')).status, 200, path);
}
for (const request of ['', 'GET', '\0\0\0', '\r\n\r\n', 'GET / HTTP/1.1\r\n\r\n', 'GET / HTTP/9.9\r\n\r\n']) {
  await raw(request);
  assert.equal((await ask('/file.bcc4')).status, 200, request);
}
server.stop();
console.log('the server holds');
