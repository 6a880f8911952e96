// SPDX-License-Identifier: Apache-2.0
// A small server of static files that answers range requests: node serve.mjs SITE [DATA] [PORT].
// SITE holds the page; what is not there is looked for in DATA.
import { createReadStream, promises } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join, normalize, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const types = {
  '.html': 'text/html; charset=utf-8',
  '.css': 'text/css; charset=utf-8',
  '.mjs': 'text/javascript; charset=utf-8',
  '.wasm': 'application/wasm',
};

async function find(folders, path) {
  const within = normalize(decodeURIComponent(path)).replace(/^(\.\.[/\\])+/, '');
  for (const folder of folders) {
    const file = resolve(join(folder, within.endsWith('/') ? within + 'index.html' : within));
    if (!file.startsWith(resolve(folder))) continue;
    const info = await promises.stat(file).catch(() => undefined);
    if (info?.isFile()) return { file, size: info.size };
  }
  return undefined;
}

// Returns first and last byte of "bytes=A-B"; undefined: all of it.
export function rangeOf(header, size) {
  const told = /^bytes=(\d*)-(\d*)$/.exec(header ?? '');
  if (!told || (!told[1] && !told[2])) return undefined;
  if (!told[1]) return { first: Math.max(0, size - Number(told[2])), last: size - 1 };
  return { first: Number(told[1]), last: told[2] ? Math.min(Number(told[2]), size - 1) : size - 1 };
}

// hooks.before(request, response, url): awaited; answers itself where it returns true.
export function makeServer(folders, hooks = {}) {
  return createServer(async (request, response) => {
    const url = new URL(request.url, 'http://localhost');
    if (await hooks.before?.(request, response, url)) return;
    const found = await find(folders, url.pathname);
    if (!found || !['GET', 'HEAD'].includes(request.method)) {
      response.writeHead(found ? 405 : 404, { 'Content-Type': 'text/plain' });
      return response.end(found ? 'Only GET and HEAD\n' : 'No such file\n');
    }
    const range = rangeOf(request.headers.range, found.size);
    const headers = { 'Content-Type': types[extname(found.file)] ?? 'application/octet-stream', 'Accept-Ranges': 'bytes' };
    if (range && range.first > range.last) {
      response.writeHead(416, { ...headers, 'Content-Range': `bytes */${found.size}` });
      return response.end();
    }
    if (range) headers['Content-Range'] = `bytes ${range.first}-${range.last}/${found.size}`;
    headers['Content-Length'] = range ? range.last - range.first + 1 : found.size;
    response.writeHead(range ? 206 : 200, headers);
    if (request.method === 'HEAD' || found.size === 0) return response.end();
    createReadStream(found.file, range ? { start: range.first, end: range.last } : {}).pipe(response);
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
