// SPDX-License-Identifier: Apache-2.0
// Where a file's bytes come from: a server that answers range requests, or a file of the user's.

export interface Source {
  readonly size: number;
  readonly name: string;
  fetch(offset: number, size: number, signal: AbortSignal): Promise<Uint8Array>;
}

// A failure whose text is meant for the user.
export class SourceError extends Error {}

// Of the first request, which most files are opened by.
const firstBytes = 64 << 10;

const noRanges =
  'The server does not answer range requests, so the file cannot be read in parts. Serve it by a server that does ' +
  '(nginx, Apache, Caddy, S3, GitHub Pages, examples/web/serve.sh), or download the file and drop it here.';

async function request(url: string, init: RequestInit): Promise<Response> {
  try {
    return await fetch(url, init);
  } catch (e) {
    if ((e as Error).name === 'AbortError') throw e;
    throw new SourceError(await reasonOf(url));
  }
}

// Browsers do not tell why a request failed; a request that needs no permission tells the two reasons apart.
async function reasonOf(url: string): Promise<string> {
  const host = new URL(url).host;
  try {
    await fetch(url, { mode: 'no-cors', method: 'HEAD' });
    return (
      `The server ${host} does not let other pages read this file (CORS). It has to send ` +
      '"Access-Control-Allow-Origin: *" and "Access-Control-Expose-Headers: Content-Range" and allow the header Range; ' +
      'or download the file and drop it here.'
    );
  } catch {
    return `The server ${host} cannot be reached. Check the address and the network, then try again.`;
  }
}

function check(answer: Response, url: string): void {
  if (answer.status === 206) return;
  if (answer.status === 200) throw new SourceError(noRanges);
  if (answer.status === 404) throw new SourceError(`There is no file at ${url}. Check the address.`);
  if (answer.status === 401 || answer.status === 403)
    throw new SourceError(`The server does not give ${url} to anybody (status ${answer.status}).`);
  throw new SourceError(`The server answered with status ${answer.status} for ${url}. Try again later.`);
}

// The size of the whole file, where the server lets a page see it.
async function sizeOf(answer: Response, url: string): Promise<number> {
  const told = /\/(\d+)$/.exec(answer.headers.get('Content-Range') ?? '');
  if (told) return Number(told[1]);
  const head = await request(url, { method: 'HEAD' });
  const size = Number(head.headers.get('Content-Length'));
  if (!(size > 0))
    throw new SourceError(
      'The server does not tell how large the file is: it has to send ' +
        '"Access-Control-Expose-Headers: Content-Range, Content-Length".',
    );
  return size;
}

class UrlSource implements Source {
  constructor(
    readonly name: string,
    private readonly url: string,
    readonly size: number,
  ) {}
  async fetch(offset: number, size: number, signal: AbortSignal): Promise<Uint8Array> {
    const answer = await request(this.url, { headers: { Range: `bytes=${offset}-${offset + size - 1}` }, signal });
    check(answer, this.url);
    return new Uint8Array(await answer.arrayBuffer());
  }
}

class BlobSource implements Source {
  readonly size: number;
  readonly name: string;
  constructor(private readonly blob: Blob) {
    this.size = blob.size;
    this.name = (blob as File).name ?? 'file';
  }
  async fetch(offset: number, size: number): Promise<Uint8Array> {
    return new Uint8Array(await this.blob.slice(offset, offset + size).arrayBuffer());
  }
}

export interface Opened {
  source: Source;
  first: Uint8Array; // from offset 0 on
}

export async function openUrl(url: string): Promise<Opened> {
  const answer = await request(url, { headers: { Range: `bytes=0-${firstBytes - 1}` } });
  check(answer, url);
  const size = await sizeOf(answer, url);
  const first = new Uint8Array(await answer.arrayBuffer());
  return { source: new UrlSource(url, url, size), first };
}

export async function openBlob(blob: Blob): Promise<Opened> {
  const source = new BlobSource(blob);
  return { source, first: await source.fetch(0, Math.min(firstBytes, blob.size)) };
}
