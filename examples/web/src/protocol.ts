// SPDX-License-Identifier: Apache-2.0
// What the page and the engine, which runs in a worker where that can draw, tell each other.

export type Mode = 1 | 2 | 3 | 4; // composite, surface, X-ray, maximum: BCCSPLAT_MODE_...

// A transfer function as bccsplat_transfer_function has it: values with linear colours, values with opacities.
export interface Look {
  kind: number;
  range: [number, number];
  iso: number;
  colors: number[];
  opacities: number[];
}

export interface Channel {
  name: string;
  unit: string;
  air: number;
  labels: number; // 1: values are labels, which nothing lies between
  range: [number, number];
  keptRange: [number, number];
  histogram: number[];
}

// Where the samples stand along an axis, if not evenly, and their unit, if it is not that of space.
export interface Axis {
  places: number[];
  down: number; // 1: places count against the axis of the world, as depths do
  unit: string;
}

export interface VolumeInfo {
  dims: [number, number, number, number];
  across: [number, number, number]; // samples from the first place of each axis of the domain to its last
  affine: number[];
  axes: [Axis, Axis, Axis];
  times: number[];
  timeEnd: number;
  voxel: number;
  spatialUnit: string;
  timeUnit: string;
  levels: number;
  bytes: number;
  channels: Channel[];
}

// All that a picture depends on. Places and boxes are fractions of the domain.
export interface View {
  time: number;
  channel: number;
  mode: Mode;
  look: number; // BCCSPLAT_LOOK_...
  iso: number | null; // null: the look's
  window: [number, number] | null; // values that the look's points are moved to; null: as they are
  opacity: number;
  shading: boolean;
  perspective: boolean;
  turnX: number;
  turnY: number;
  zoom: number;
  panX: number;
  panY: number;
  clip: [number, number, number, number, number, number];
  cross: [number, number, number];
  planes: boolean;
}

export interface Camera {
  position: [number, number, number];
  target: [number, number, number];
  up: [number, number, number];
  perspective: number;
  fovy: number;
  height: number;
}

export interface Plane {
  width: number;
  height: number;
  values: Float32Array;
}

export interface Traffic {
  bytes: number;
  requests: number;
  pending: number;
}

export type ToEngine =
  | { kind: 'start'; canvas: OffscreenCanvas | HTMLCanvasElement; core: string }
  | { kind: 'open'; url?: string; file?: Blob }
  | { kind: 'view'; view: View; width: number; height: number; background: [number, number, number]; moving: boolean }
  | { kind: 'ahead'; from: number; to: number }
  | { kind: 'snapshot'; id: number };

export type FromEngine =
  | { kind: 'ready'; renderer: string }
  | { kind: 'opened'; info: VolumeInfo }
  | { kind: 'look'; look: Look; channel: number }
  | { kind: 'drawn'; time: number; camera: Camera; ms: number; level: number; preview: boolean }
  | { kind: 'planes'; planes: Plane[]; value: number; channel: number; cross: View['cross'] }
  | { kind: 'traffic'; traffic: Traffic }
  | { kind: 'snapshot'; id: number; image: ImageBitmap }
  | { kind: 'waiting'; time: number }
  | { kind: 'lost' } // the context of the canvas, and with it the picture
  | { kind: 'restored' }
  | { kind: 'failed'; text: string; fatal: boolean }
  | { kind: 'no-webgl2' };
