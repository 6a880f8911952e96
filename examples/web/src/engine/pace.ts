// SPDX-License-Identifier: Apache-2.0
// How large pictures are drawn while something moves, so that they keep up: smaller ones where the GPU is slow.

const slow = 55; // milliseconds of a picture
const fast = 22;
const smallest = 0.15;
const ofRasterisers = 0.25; // on the CPU

export class Pace {
  scale = 1;

  constructor(onTheCpu: boolean) {
    if (onTheCpu) this.scale = ofRasterisers;
  }

  // Whether whole pictures take so long that a smaller one comes first.
  get slow(): boolean {
    return this.scale < 0.7;
  }

  took(ms: number, moving: boolean): void {
    if (!moving) return;
    if (ms > slow) this.scale = Math.max(smallest, this.scale * Math.max(0.5, Math.sqrt(slow / ms)));
    else if (ms < fast) this.scale = Math.min(1, this.scale * 1.1);
  }
}
