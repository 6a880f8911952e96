// SPDX-License-Identifier: Apache-2.0
// A small server of static files that answers range requests: node serve.mjs SITE [DATA] [PORT].
// SITE holds the page; what is not there is looked for in DATA.
import { createReadStream, promises } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join, normalize, resolve, sep } from 'node:path';
import { pipeline } from 'node:stream/promises';
import { pathToFileURL } from 'node:url';

const types = {
  '.html': 'text/html; charset=utf-8',
  '.css': 'text/css; charset=utf-8',
  '.mjs': 'text/javascript; charset=utf-8',
  '.wasm': 'application/wasm',
};

async function find(folders, path) {
  const within = normalize(path).replace(/^(\.\.[/\\])+/, '');
  for (const folder of folders.map((name) => resolve(name))) {
    const file = resolve(join(folder, within.endsWith('/') ? within + 'index.html' : within));
    if (!file.startsWith(folder.endsWith(sep) ? folder : folder + sep)) continue;
    const info = await promises.stat(file).catch(() => undefined);
    if (info?.isFile()) return { file, size: info.size };
  }
  return undefined;
}

// Returns first and last byte of "bytes=A-B"; undefined: all of it, which several ranges and what is no range mean, too. What
// begins behind its end cannot be given.
export function rangeOf(header, size) {
  const told = /^bytes=(\d*)-(\d*)$/i.exec(header ?? '');
  if (!told || (!told[1] && !told[2])) return undefined;
  if (!told[1]) return { first: Math.max(0, size - Number(told[2])), last: size - 1 };
  if (told[2] && BigInt(told[2]) < BigInt(told[1])) return undefined;
  return { first: Number(told[1]), last: told[2] ? Math.min(Number(told[2]), size - 1) : size - 1 };
}

// Pages of other sites whose own name was led to this machine (DNS rebinding) send that name.
function namesThisServer(host, port) {
  return ['127.0.0.1', 'localhost'].some((own) => host.toLowerCase() === (port === 80 ? own : `${own}:${port}`));
}

function refuse(response, status, text, headers = {}) {
  response.writeHead(status, { 'Content-Type': 'text/plain', ...headers });
  response.end(text + '\n');
}

async function answer(folders, hooks, request, response) {
  if (!namesThisServer(request.headers.host ?? '', request.socket.localPort)) {
    return refuse(response, 403, 'Only as 127.0.0.1 or localhost, with the port');
  }
  let url, path;
  try {
    url = new URL('http://localhost' + request.url);
    path = decodeURIComponent(url.pathname);
  } catch {
    return refuse(response, 400, 'No address');
  }
  if (await hooks.before?.(request, response, url)) return;
  if (!['GET', 'HEAD'].includes(request.method)) return refuse(response, 405, 'Only GET and HEAD', { Allow: 'GET, HEAD' });
  const found = await find(folders, path);
  if (!found) return refuse(response, 404, 'No such file');
  // A range is meant for GET alone, and under a condition for a version that is named; ours have no names.
  const inParts = request.method === 'GET' && !request.headers['if-range'];
  const range = inParts ? rangeOf(request.headers.range, found.size) : undefined;
  if (range && range.first > range.last) {
    return refuse(response, 416, 'The file has fewer bytes', { 'Content-Range': `bytes */${found.size}` });
  }
  const headers = { 'Content-Type': types[extname(found.file)] ?? 'application/octet-stream', 'Accept-Ranges': 'bytes' };
  if (range) headers['Content-Range'] = `bytes ${range.first}-${range.last}/${found.size}`;
  headers['Content-Length'] = range ? range.last - range.first + 1 : found.size;
  response.writeHead(range ? 206 : 200, headers);
  if (request.method === 'HEAD' || found.size === 0) return response.end();
  // A file that grows has more by now than was told.
  const { first, last } = range ?? { first: 0, last: found.size - 1 };
  await pipeline(createReadStream(found.file, { start: first, end: last }), response);
}

// hooks.before(request, response, url): awaited; answers itself where it returns true. Listen on 127.0.0.1.
export function makeServer(folders, hooks = {}) {
  return createServer((request, response) => {
    // Who has gone in the middle, or a file that has, ends the answer alone.
    answer(folders, hooks, request, response).catch(() => response.destroy());
  });
}

if (process.argv[1] && import.meta.url === pathToFileURL(process.argv[1]).href) {
  const [site, data, port] = process.argv.slice(2);
  if (!site) {
    console.error('serve.mjs SITE [DATA] [PORT]');
    process.exit(2);
  }
  const server = makeServer(data ? [site, data] : [site]);
  server.listen(Number(port ?? 8000), '127.0.0.1', () => {
    console.log(`http://127.0.0.1:${server.address().port}/`);
  });
}
