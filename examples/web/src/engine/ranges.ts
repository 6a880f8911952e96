// SPDX-License-Identifier: Apache-2.0
// Byte ranges of a file, and the pieces of it that are here.

export interface Range {
  offset: number;
  size: number;
}

// Returns the ranges sorted, merged where no more than `gap` bytes lie between them.
export function merged(ranges: Range[], gap: number): Range[] {
  const out: Range[] = [];
  for (const r of [...ranges].sort((a, b) => a.offset - b.offset)) {
    const last = out[out.length - 1];
    if (last && r.offset <= last.offset + last.size + gap)
      last.size = Math.max(last.size, r.offset + r.size - last.offset);
    else out.push({ ...r });
  }
  return out;
}

interface Piece {
  offset: number;
  bytes: Uint8Array;
  used: number;
}

// Pieces of a file, at most so many bytes of them: those that were not used for the longest time go.
export class Pieces {
  private pieces: Piece[] = [];
  private held = 0;
  private clock = 0;
  constructor(private readonly limit: number) {}

  add(offset: number, bytes: Uint8Array): void {
    this.pieces.push({ offset, bytes, used: ++this.clock });
    this.held += bytes.length;
    while (this.held > this.limit && this.pieces.length > 1) this.drop();
  }

  private drop(): void {
    let oldest = 0;
    this.pieces.forEach((p, n) => {
      if (p.used < this.pieces[oldest].used) oldest = n;
    });
    this.held -= this.pieces[oldest].bytes.length;
    this.pieces.splice(oldest, 1);
  }

  // Fills `out` with the bytes at an offset; false where some are not here.
  read(offset: number, out: Uint8Array): boolean {
    let at = offset;
    const end = offset + out.length;
    while (at < end) {
      const p = this.holding(at);
      if (!p) return false;
      const count = Math.min(end, p.offset + p.bytes.length) - at;
      out.set(p.bytes.subarray(at - p.offset, at - p.offset + count), at - offset);
      p.used = ++this.clock;
      at += count;
    }
    return true;
  }

  has(range: Range): boolean {
    let at = range.offset;
    while (at < range.offset + range.size) {
      const p = this.holding(at);
      if (!p) return false;
      at = p.offset + p.bytes.length;
    }
    return true;
  }

  private holding(at: number): Piece | undefined {
    return this.pieces.find((p) => p.offset <= at && at < p.offset + p.bytes.length);
  }
}
