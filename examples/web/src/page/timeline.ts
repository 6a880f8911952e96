// SPDX-License-Identifier: Apache-2.0
// Any moment of the series: a slider, play with its speed, and loop.
import type { VolumeInfo } from '../protocol';
import { element } from './dom';
import { timeText } from './format';

const steps = 10000; // of the slider
const secondsOfAll = 8; // that a series plays at speed 1
const aheadSeconds = 2;

export interface TimeHost {
  time(): number;
  setTime(time: number, moving: boolean): void;
  // Moments that will be played next.
  ahead(from: number, to: number): void;
  // Whether the picture of the last moment is still on its way.
  waits(): boolean;
}

export class Timeline {
  private readonly button = element('button', { type: 'button', class: 'play', 'aria-label': 'Play', click: () => this.toggle() }, '▶');
  private readonly slider = element('input', { type: 'range', min: 0, max: steps, value: 0, 'aria-label': 'Time' });
  private readonly shown = element('output', { class: 'time' });
  private readonly speed = element(
    'select',
    { 'aria-label': 'Speed' },
    ...['0.25', '0.5', '1', '2', '4'].map((s) => element('option', { value: s, selected: s === '1' }, `${s}×`)),
  );
  private readonly loop = element('input', { type: 'checkbox', checked: true });
  readonly root = element(
    'div',
    { class: 'timeline', role: 'group', 'aria-label': 'Time' },
    this.button,
    this.slider,
    this.shown,
    this.speed,
    element('label', { class: 'check' }, this.loop, 'Loop'),
  );
  private info: VolumeInfo | undefined;
  private playing = false;
  private last = 0;
  private aheadTo = NaN;

  constructor(private readonly host: TimeHost) {
    this.slider.addEventListener('input', () => this.host.setTime(this.timeAt(Number(this.slider.value)), true));
    this.slider.addEventListener('change', () => this.host.setTime(this.timeAt(Number(this.slider.value)), false));
  }

  open(info: VolumeInfo): void {
    this.info = info;
    this.stop();
    this.root.hidden = info.times.length < 2;
    this.show();
  }

  private get first(): number {
    return this.info!.times[0];
  }
  private get end(): number {
    return this.info!.timeEnd;
  }
  private timeAt(step: number): number {
    return this.first + ((this.end - this.first) * step) / steps;
  }

  show(): void {
    if (!this.info) return;
    const time = this.host.time();
    this.slider.value = String(Math.round(((time - this.first) / (this.end - this.first || 1)) * steps));
    this.shown.textContent = timeText(time, this.info);
    this.slider.setAttribute('aria-valuetext', this.shown.textContent);
  }

  // To the frame so many frames away.
  step(frames: number): void {
    const { times } = this.info!;
    const time = this.host.time();
    const nearest = times.reduce((best, t, n) => (Math.abs(t - time) < Math.abs(times[best] - time) ? n : best), 0);
    this.host.setTime(times[Math.max(0, Math.min(times.length - 1, nearest + frames))], false);
  }

  toggle(): void {
    if (this.playing) return this.stop();
    if (!this.info || this.info.times.length < 2) return;
    this.playing = true;
    this.mark();
    if (this.host.time() >= this.end) this.host.setTime(this.first, true);
    this.last = performance.now();
    this.aheadTo = NaN;
    requestAnimationFrame((now) => this.tick(now));
  }

  stop(): void {
    if (!this.playing) return;
    this.playing = false;
    this.mark();
    this.host.setTime(this.host.time(), false);
  }

  private mark(): void {
    this.button.textContent = this.playing ? '❚❚' : '▶';
    this.button.setAttribute('aria-label', this.playing ? 'Pause' : 'Play');
  }

  get isPlaying(): boolean {
    return this.playing;
  }
  // Of time, per second.
  get rate(): number {
    return ((this.end - this.first) / secondsOfAll) * Number(this.speed.value);
  }

  private tick(now: number): void {
    if (!this.playing) return;
    // A frame's time may be before the moment that play was asked for.
    const passed = Math.max(0, Math.min((now - this.last) / 1000, 0.25));
    this.last = now;
    if (!this.host.waits()) this.advance(passed * this.rate);
    requestAnimationFrame((then) => this.tick(then));
  }

  private advance(by: number): void {
    let time = this.host.time() + by;
    if (time > this.end) {
      if (!this.loop.checked) {
        this.host.setTime(this.end, true);
        return this.stop();
      }
      time = this.first + ((time - this.first) % (this.end - this.first));
      this.aheadTo = NaN;
    }
    this.host.setTime(time, true);
    this.lookAhead(time);
  }

  // Asks for the next seconds when half of the last ones were played.
  private lookAhead(time: number): void {
    const reach = aheadSeconds * this.rate;
    if (this.aheadTo - time > reach / 2) return;
    const from = Number.isNaN(this.aheadTo) ? time : this.aheadTo;
    this.aheadTo = Math.min(time + reach, this.end);
    if (this.aheadTo > from) this.host.ahead(from, this.aheadTo);
    if (this.aheadTo === this.end) this.aheadTo = Infinity;
  }
}
