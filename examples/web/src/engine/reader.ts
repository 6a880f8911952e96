// SPDX-License-Identifier: Apache-2.0
// Fetches the ranges of a source, at most six at once, and keeps them for the core.
import { merged, Pieces, type Range } from './ranges';
import { openBlob, openUrl, type Source } from './source';
import type { Traffic } from '../protocol';

const mostAtOnce = 6;
const gap = 256 << 10; // bytes that cost less than another request does
const piecesHeld = 96 << 20;

export class Reader {
  private readonly pieces = new Pieces(piecesHeld);
  private readonly pending = new Map<string, Promise<void>>();
  private active = 0;
  private queue: (() => void)[] = [];
  private stop = new AbortController();
  readonly traffic: Traffic = { bytes: 0, requests: 0, pending: 0 };

  private constructor(
    private readonly source: Source,
    private readonly told: (traffic: Traffic) => void,
  ) {}

  static async open(from: { url?: string; file?: Blob }, told: (traffic: Traffic) => void): Promise<Reader> {
    const { source, first } = from.file ? await openBlob(from.file) : await openUrl(from.url!);
    const reader = new Reader(source, told);
    reader.pieces.add(0, first);
    reader.count(first.length);
    return reader;
  }

  get size(): number {
    return this.source.size;
  }

  read(offset: number, out: Uint8Array): boolean {
    return this.pieces.read(offset, out);
  }

  // Resolves when all of these are here.
  async fetch(ranges: Range[]): Promise<void> {
    const wanted = merged(
      ranges.filter((r) => !this.pieces.has(r)),
      gap,
    );
    await Promise.all(wanted.map((r) => this.one(r)));
  }

  // Gives up what is on its way: nobody waits for it any more.
  dropPending(): void {
    this.stop.abort();
    this.stop = new AbortController();
    this.queue.splice(0).forEach((go) => go());
    this.pending.clear();
  }

  private one(r: Range): Promise<void> {
    const key = `${r.offset}+${r.size}`;
    const known = this.pending.get(key);
    if (known) return known;
    const made = this.run(r).finally(() => this.pending.delete(key));
    this.pending.set(key, made);
    return made;
  }

  private async run(r: Range): Promise<void> {
    const { signal } = this.stop;
    if (this.active >= mostAtOnce) await new Promise<void>((go) => this.queue.push(go));
    if (signal.aborted) throw new DOMException('moved on', 'AbortError');
    ++this.active;
    this.tell();
    try {
      const bytes = await this.source.fetch(r.offset, r.size, signal);
      this.pieces.add(r.offset, bytes);
      this.count(bytes.length);
    } finally {
      --this.active;
      this.queue.shift()?.();
      this.tell();
    }
  }

  private count(bytes: number): void {
    this.traffic.bytes += bytes;
    ++this.traffic.requests;
    this.tell();
  }

  private tell(): void {
    this.traffic.pending = this.active;
    this.told({ ...this.traffic });
  }
}
