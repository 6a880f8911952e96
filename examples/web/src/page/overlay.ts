// SPDX-License-Identifier: Apache-2.0
// What is drawn over the picture: the domain's box with its axes, the cross-hair, scale bar, colour bar, time.
import type { Camera, VolumeInfo, View } from '../protocol';
import type { Shades } from './colors';
import { sized, themed } from './dom';
import { number, roundLength, timeText, withUnit } from './format';
import { Projection, toWorld } from './project';

export interface Seen {
  info: VolumeInfo;
  view: View;
  camera: Camera;
  shades: Shades | undefined;
  time: number; // of the picture
}

type Vector = [number, number, number];
const font = '12px system-ui, sans-serif';
const axisColors = ['--axis-x', '--axis-y', '--axis-z'];
const barWidth = 12;
const narrow = 480; // pixels of a picture on which there is less room
const hidden = 0.35; // of the ink of edges behind the volume
const margin = 10; // around names of axes

// The corner of the domain that is farthest from the eye.
function farthest(info: VolumeInfo, camera: Camera): Vector {
  const ahead = camera.target.map((x, a) => x - camera.position[a]);
  const [start, ...ends] = [0, 1, 2, 3].map((n) => {
    const corner: Vector = [0, 0, 0];
    if (n > 0) corner[n - 1] = 1;
    return toWorld(info, corner).reduce((sum, x, a) => sum + x * ahead[a], 0);
  });
  return ends.map((end) => (end > start ? 1 : 0)) as Vector;
}

export class Overlay {
  constructor(readonly canvas: HTMLCanvasElement) {}

  draw(seen: Seen): void {
    const c = sized(this.canvas);
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    const project = new Projection(seen.camera, width, height);
    c.font = font;
    c.lineWidth = 1;
    const ink = themed('--ink', this.canvas), faint = themed('--line', this.canvas);
    this.box(c, seen, project, faint);
    if (seen.view.planes) this.cross(c, seen, project);
    this.scaleBar(c, seen, project, ink, height);
    if (seen.shades && (seen.view.mode === 1 || seen.view.mode === 4)) this.colorBar(c, seen, ink, width, height);
    this.time(c, seen, ink);
  }

  private line(c: CanvasRenderingContext2D, project: Projection, info: VolumeInfo, from: Vector, to: Vector): void {
    const a = project.at(toWorld(info, from)), b = project.at(toWorld(info, to));
    if (!a || !b) return;
    c.beginPath();
    c.moveTo(...a);
    c.lineTo(...b);
    c.stroke();
  }

  // The edges from the first corner in the colours of their axes, named at their ends; those that meet at the
  // corner farthest away are behind the volume, and fainter.
  private box(c: CanvasRenderingContext2D, { info, camera }: Seen, project: Projection, faint: string): void {
    const far = farthest(info, camera);
    for (let axis = 0; axis < 3; ++axis)
      for (let n = 0; n < 4; ++n) {
        const from: Vector = [0, 0, 0];
        from[(axis + 1) % 3] = n & 1;
        from[(axis + 2) % 3] = n >> 1;
        const to = [...from] as Vector;
        to[axis] = 1;
        const behind = from.every((x, a) => a === axis || x === far[a]);
        c.globalAlpha = behind ? hidden : 1;
        c.strokeStyle = n === 0 ? themed(axisColors[axis], this.canvas) : faint;
        this.line(c, project, info, from, to);
        c.globalAlpha = 1;
        if (n === 0) this.axisName(c, info, project, axis);
      }
  }

  private axisName(c: CanvasRenderingContext2D, info: VolumeInfo, project: Projection, axis: number): void {
    const end: Vector = [0, 0, 0];
    end[axis] = 1.06;
    const at = project.at(toWorld(info, end));
    if (!at) return;
    c.fillStyle = themed(axisColors[axis], this.canvas);
    c.textAlign = 'center';
    c.textBaseline = 'middle';
    const inside = (x: number, size: number) => Math.max(margin, Math.min(size - margin, x));
    c.fillText('xyz'[axis], inside(at[0], this.canvas.clientWidth), inside(at[1], this.canvas.clientHeight));
  }

  private cross(c: CanvasRenderingContext2D, { info, view }: Seen, project: Projection): void {
    c.setLineDash([4, 3]);
    for (let axis = 0; axis < 3; ++axis) {
      const from = [...view.cross] as Vector, to = [...view.cross] as Vector;
      from[axis] = 0;
      to[axis] = 1;
      c.strokeStyle = themed(axisColors[axis], this.canvas);
      this.line(c, project, info, from, to);
    }
    c.setLineDash([]);
  }

  private scaleBar(c: CanvasRenderingContext2D, { info }: Seen, project: Projection, ink: string, height: number): void {
    const length = roundLength(110 * project.pixel), wide = length / project.pixel;
    const x = 16, y = height - 18;
    c.strokeStyle = c.fillStyle = ink;
    c.lineWidth = 2;
    c.beginPath();
    c.moveTo(x, y - 4);
    c.lineTo(x, y);
    c.lineTo(x + wide, y);
    c.lineTo(x + wide, y - 4);
    c.stroke();
    c.lineWidth = 1;
    c.textAlign = 'left';
    c.textBaseline = 'bottom';
    c.fillText(withUnit(length, info.spatialUnit), x, y - 6);
  }

  private colorBar(c: CanvasRenderingContext2D, seen: Seen, ink: string, width: number, height: number): void {
    const shades = seen.shades!;
    const [from, to] = shades.range;
    const tall = Math.min(180, height * (width < narrow ? 0.22 : 0.35));
    const x = width - 16 - barWidth, y = height - 18 - tall;
    for (let n = 0; n < tall; ++n) {
      c.fillStyle = `rgb(${shades.color(to + ((from - to) * n) / (tall - 1)).join()})`;
      c.fillRect(x, y + n, barWidth, 1.5);
    }
    c.fillStyle = ink;
    c.textAlign = 'right';
    c.textBaseline = 'middle';
    for (let n = 0; n <= 2; ++n) c.fillText(number(to + ((from - to) * n) / 2), x - 6, y + (tall * n) / 2);
    const channel = seen.info.channels[seen.view.channel];
    const name = channel.unit ? `${channel.name} (${channel.unit})` : channel.name;
    c.textAlign = 'right';
    c.textBaseline = 'bottom';
    c.fillText(name, width - 16, y - 10);
  }

  private time(c: CanvasRenderingContext2D, { info, time }: Seen, ink: string): void {
    if (info.times.length < 2) return;
    c.fillStyle = ink;
    c.textAlign = 'left';
    c.textBaseline = 'top';
    c.font = `600 ${font}`;
    c.fillText(`t = ${timeText(time, info)}`, 16, 16);
  }
}
