// SPDX-License-Identifier: Apache-2.0
// The example's server, which counts and delays what is asked of it, and misbehaves on request: ?ranges=no, ?status=403, ?held until
// what it holds by has come; where it refuses, it hangs up.
import { makeServer } from '../../examples/web/serve.mjs';

export class CountingServer {
  requests = [];
  latency = 0;
  refuses = false;
  held; // a promise

  constructor(folders, extra = {}) {
    this.server = makeServer(folders, {
      before: async (request, response, url) => {
        if (url.pathname.endsWith('.bcc4')) await this.count(request, response);
        if (this.refuses) {
          request.socket.destroy();
          return true;
        }
        if (extra[url.pathname]) {
          response.writeHead(200, { 'Content-Type': 'text/html' });
          response.end(extra[url.pathname]);
          return true;
        }
        if (url.searchParams.get('ranges') === 'no') delete request.headers.range;
        if (url.searchParams.has('held')) await this.held;
        const status = Number(url.searchParams.get('status'));
        if (status) response.writeHead(status).end();
        return status > 0;
      },
    });
  }
  async count(request, response) {
    const seen = { range: request.headers.range ?? 'all', start: performance.now(), end: Infinity };
    this.requests.push(seen);
    response.on('close', () => (seen.end = performance.now()));
    if (this.latency) await new Promise((go) => setTimeout(go, this.latency));
  }
  // How many of the requests came one after the other: after the end of all before them.
  rounds() {
    let count = 0, end = -Infinity;
    for (const { start, end: until } of this.requests) {
      if (start >= end) ++count;
      end = Math.max(end, until);
    }
    return count;
  }
  bytes() {
    const size = (range) => {
      const told = /(\d+)-(\d+)/.exec(range);
      return told ? Number(told[2]) - Number(told[1]) + 1 : 0;
    };
    return this.requests.reduce((sum, { range }) => sum + size(range), 0);
  }
  async start() {
    await new Promise((go) => this.server.listen(0, '127.0.0.1', go));
    this.base = `http://127.0.0.1:${this.server.address().port}`;
    return this;
  }
  stop() {
    this.server.closeAllConnections?.();
    this.server.close();
  }
}
