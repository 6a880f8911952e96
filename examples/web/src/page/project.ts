// SPDX-License-Identifier: Apache-2.0
// Where places of the world are in the picture.
import type { Camera, VolumeInfo } from '../protocol';

type Vector = [number, number, number];
const minus = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a: Vector, b: Vector) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Vector, b: Vector): Vector => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
const unit = (a: Vector): Vector => {
  const length = Math.hypot(...a);
  return [a[0] / length, a[1] / length, a[2] / length];
};

// A fraction of the domain, in the world.
export function toWorld(info: VolumeInfo, at: Vector): Vector {
  const index = at.map((x, a) => x * info.across[a]);
  const row = (r: number) =>
    info.affine[4 * r] * index[0] + info.affine[4 * r + 1] * index[1] + info.affine[4 * r + 2] * index[2] + info.affine[4 * r + 3];
  return [row(0), row(1), row(2)];
}

export class Projection {
  private readonly right: Vector;
  private readonly up: Vector;
  private readonly ahead: Vector;
  constructor(
    private readonly camera: Camera,
    private readonly width: number,
    private readonly height: number,
  ) {
    this.ahead = unit(minus(camera.target, camera.position));
    this.right = unit(cross(this.ahead, camera.up));
    this.up = cross(this.right, this.ahead);
  }
  // Pixels; null behind the eye.
  at(world: Vector): [number, number] | null {
    const from = minus(world, this.camera.position);
    const depth = dot(from, this.ahead);
    if (this.camera.perspective && depth <= 0) return null;
    const tall = this.camera.perspective ? 2 * depth * Math.tan((this.camera.fovy * Math.PI) / 360) : this.camera.height;
    const scale = this.height / tall;
    return [this.width / 2 + dot(from, this.right) * scale, this.height / 2 - dot(from, this.up) * scale];
  }
  // World length of a pixel at the target.
  get pixel(): number {
    const away = Math.hypot(...minus(this.camera.target, this.camera.position));
    const tall = this.camera.perspective ? 2 * away * Math.tan((this.camera.fovy * Math.PI) / 360) : this.camera.height;
    return tall / this.height;
  }
}
