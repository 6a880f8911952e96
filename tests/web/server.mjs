// SPDX-License-Identifier: Apache-2.0
// The example's server, which counts and delays what is asked of it, and misbehaves on request: ?ranges=no, ?status=403.
import { makeServer } from '../../examples/web/serve.mjs';

export class CountingServer {
  requests = [];
  latency = 0;

  constructor(folders, extra = {}) {
    this.server = makeServer(folders, {
      before: async (request, response, url) => {
        if (url.pathname.endsWith('.bcc4')) await this.count(request);
        if (extra[url.pathname]) {
          response.writeHead(200, { 'Content-Type': 'text/html' });
          response.end(extra[url.pathname]);
          return true;
        }
        if (url.searchParams.get('ranges') === 'no') delete request.headers.range;
        const status = Number(url.searchParams.get('status'));
        if (status) response.writeHead(status).end();
        return status > 0;
      },
    });
  }
  async count(request) {
    this.requests.push(request.headers.range ?? 'all');
    if (this.latency) await new Promise((go) => setTimeout(go, this.latency));
  }
  bytes() {
    const size = (range) => {
      const told = /(\d+)-(\d+)/.exec(range);
      return told ? Number(told[2]) - Number(told[1]) + 1 : 0;
    };
    return this.requests.reduce((sum, range) => sum + size(range), 0);
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
