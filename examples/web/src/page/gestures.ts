// SPDX-License-Identifier: Apache-2.0
// Turning, moving and enlarging the picture: by mouse, touch and keys.
import type { View } from '../protocol';

export interface GestureHost {
  view: View;
  changed(moving: boolean): void;
  toggle(what: 'play' | 'planes'): void;
  step(frames: number): void;
  home(): void;
}

const degreesPerPixel = 0.4;
const degreesPerKey = 5;
const zoomPerWheel = 0.0015;
const zoomPerKey = 1.15;
const smallest = 0.1;
const largest = 60;

export function addGestures(target: HTMLElement, host: GestureHost): void {
  const down = new Map<number, { x: number; y: number }>();
  let spread = 0;

  const turn = (dx: number, dy: number) => {
    host.view.turnY = (host.view.turnY - dx * degreesPerPixel) % 360;
    host.view.turnX = Math.max(-90, Math.min(90, host.view.turnX + dy * degreesPerPixel));
  };
  const pan = (dx: number, dy: number) => {
    host.view.panX += dx / target.clientHeight;
    host.view.panY -= dy / target.clientHeight;
  };
  // What is under the pointer stays there.
  const zoom = (factor: number, x: number, y: number) => {
    const to = Math.max(smallest, Math.min(largest, host.view.zoom * factor));
    const by = to / host.view.zoom;
    const px = (x - target.clientWidth / 2) / target.clientHeight, py = (target.clientHeight / 2 - y) / target.clientHeight;
    host.view.panX = px + (host.view.panX - px) * by;
    host.view.panY = py + (host.view.panY - py) * by;
    host.view.zoom = to;
  };
  const middle = () => {
    const points = [...down.values()];
    return { x: (points[0].x + points[1].x) / 2, y: (points[0].y + points[1].y) / 2 };
  };
  const distance = () => {
    const [a, b] = [...down.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };

  target.addEventListener('pointerdown', (e) => {
    target.setPointerCapture(e.pointerId);
    down.set(e.pointerId, { x: e.offsetX, y: e.offsetY });
    if (down.size === 2) spread = distance();
  });
  target.addEventListener('pointermove', (e) => {
    const last = down.get(e.pointerId);
    if (!last) return;
    const before = down.size === 2 ? middle() : last;
    down.set(e.pointerId, { x: e.offsetX, y: e.offsetY });
    if (down.size === 2) {
      const now = middle();
      pan(now.x - before.x, now.y - before.y);
      zoom(distance() / Math.max(spread, 1), now.x, now.y);
      spread = distance();
    } else if (e.shiftKey || e.buttons & 6) pan(e.offsetX - last.x, e.offsetY - last.y);
    else turn(e.offsetX - last.x, e.offsetY - last.y);
    host.changed(true);
  });
  const up = (e: PointerEvent) => {
    if (down.delete(e.pointerId)) host.changed(false);
  };
  target.addEventListener('pointerup', up);
  target.addEventListener('pointercancel', up);
  target.addEventListener('contextmenu', (e) => e.preventDefault());
  target.addEventListener('dblclick', () => host.home());
  target.addEventListener(
    'wheel',
    (e) => {
      e.preventDefault();
      zoom(Math.exp(-e.deltaY * zoomPerWheel), e.offsetX, e.offsetY);
      host.changed(true);
    },
    { passive: false },
  );

  const keys: Record<string, (e: KeyboardEvent) => void> = {
    ArrowLeft: (e) => (e.shiftKey ? pan(-20, 0) : turn(-degreesPerKey / degreesPerPixel, 0)),
    ArrowRight: (e) => (e.shiftKey ? pan(20, 0) : turn(degreesPerKey / degreesPerPixel, 0)),
    ArrowUp: (e) => (e.shiftKey ? pan(0, -20) : turn(0, -degreesPerKey / degreesPerPixel)),
    ArrowDown: (e) => (e.shiftKey ? pan(0, 20) : turn(0, degreesPerKey / degreesPerPixel)),
    '+': () => zoom(zoomPerKey, target.clientWidth / 2, target.clientHeight / 2),
    '-': () => zoom(1 / zoomPerKey, target.clientWidth / 2, target.clientHeight / 2),
    Home: () => host.home(),
    '0': () => host.home(),
    ' ': () => host.toggle('play'),
    '.': () => host.step(1),
    ',': () => host.step(-1),
    s: () => host.toggle('planes'),
  };
  target.addEventListener('keydown', (e) => {
    const act = keys[e.key];
    if (!act || e.ctrlKey || e.metaKey || e.altKey) return;
    e.preventDefault();
    act(e);
    host.changed(true);
  });
}
