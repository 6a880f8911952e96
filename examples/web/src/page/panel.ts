// SPDX-License-Identifier: Apache-2.0
// The controls of what is drawn and how.
import type { Mode, View, VolumeInfo } from '../protocol';
import { element } from './dom';
import type { Transfer } from './transfer';

const modes: [Mode, string][] = [
  [1, 'Composite'],
  [2, 'Surface'],
  [3, 'X-ray'],
  [4, 'Maximum'],
];
const looks = ['Automatic', 'CT bone', 'CT soft tissue', 'MR', 'Fog', 'Fire', 'Signed', 'Labels'];

export class Panel {
  readonly root = element('aside', { class: 'panel', 'aria-label': 'Controls' });
  private readonly channel = element('select', { id: 'channel' });
  private readonly look = element('select', { id: 'look' }, ...looks.map((l, n) => element('option', { value: n }, l)));
  private readonly modes = element('div', { class: 'segments', role: 'radiogroup', 'aria-label': 'Mode' });
  private readonly opacity = element('input', { type: 'range', min: -2, max: 2, step: 0.05, id: 'opacity' });
  private readonly iso = element('input', { type: 'range', min: 0, max: 1, step: 0.001, id: 'iso' });
  private readonly isoRow: HTMLElement;
  private readonly shading = element('input', { type: 'checkbox' });
  private readonly perspective = element('input', { type: 'checkbox' });
  private readonly planes = element('input', { type: 'checkbox' });
  private readonly clips: HTMLInputElement[] = [];
  private info: VolumeInfo | undefined;

  constructor(
    private readonly view: () => View,
    private readonly changed: (moving: boolean) => void,
    transfer: Transfer,
    actions: HTMLElement,
  ) {
    const row = (text: string, control: HTMLElement) =>
      element('div', { class: 'row' }, element('label', { for: control.id }, text), control);
    for (const [mode, name] of modes) {
      const input = element('input', { type: 'radio', name: 'mode', value: mode });
      this.modes.append(element('label', {}, input, element('span', {}, name)));
    }
    this.isoRow = row('Surface at', this.iso);
    const check = (input: HTMLInputElement, text: string) => element('label', { class: 'check' }, input, text);
    this.root.append(
      row('Channel', this.channel),
      this.modes,
      transfer.canvas,
      row('Look', this.look),
      row('Opacity', this.opacity),
      this.isoRow,
      element(
        'div',
        { class: 'checks' },
        check(this.shading, 'Light'),
        check(this.perspective, 'Perspective'),
        check(this.planes, 'Planes'),
      ),
      this.clipBox(),
      actions,
    );
    this.listen();
  }

  private clipBox(): HTMLElement {
    const box = element('details', {}, element('summary', {}, 'Clip box'));
    for (let axis = 0; axis < 3; ++axis) {
      const name = 'xyz'[axis];
      const pair = [0, 1].map((side) => {
        const input = element('input', {
          type: 'range',
          min: 0,
          max: 1,
          step: 0.005,
          value: side,
          'aria-label': `${name} ${side ? 'to' : 'from'}`,
        });
        this.clips[axis + 3 * side] = input;
        return input;
      });
      box.append(element('div', { class: 'row clip' }, element('span', {}, name), ...pair));
    }
    return box;
  }

  private listen(): void {
    const on = (input: HTMLElement, set: () => void) => {
      input.addEventListener('input', () => {
        set();
        this.changed(input instanceof HTMLInputElement && input.type === 'range');
      });
      input.addEventListener('change', () => {
        set();
        this.changed(false);
        this.show();
      });
    };
    on(this.channel, () => {
      this.view().channel = Number(this.channel.value);
      this.view().window = this.view().iso = null;
    });
    on(this.look, () => {
      this.view().look = Number(this.look.value);
      this.view().window = null;
    });
    on(this.modes, () => {
      const mode = this.modes.querySelector<HTMLInputElement>('input:checked');
      if (mode) this.view().mode = Number(mode.value) as Mode;
    });
    on(this.opacity, () => (this.view().opacity = 10 ** Number(this.opacity.value)));
    on(this.iso, () => (this.view().iso = this.isoAt(Number(this.iso.value))));
    on(this.shading, () => (this.view().shading = this.shading.checked));
    on(this.perspective, () => (this.view().perspective = this.perspective.checked));
    on(this.planes, () => (this.view().planes = this.planes.checked));
    this.clips.forEach((input, n) => on(input, () => this.setClip(n)));
  }

  // The two ends of an axis stay apart.
  private setClip(n: number): void {
    const { clip } = this.view();
    clip[n] = Number(this.clips[n].value);
    const other = (n + 3) % 6;
    if (n < 3 && clip[n] > clip[other] - 0.01) clip[n] = Math.max(0, clip[other] - 0.01);
    if (n >= 3 && clip[n] < clip[other] + 0.01) clip[n] = Math.min(1, clip[other] + 0.01);
  }

  private isoAt(share: number): number {
    const [from, to] = this.info!.channels[this.view().channel].keptRange;
    return from + (to - from) * share;
  }

  open(info: VolumeInfo): void {
    this.info = info;
    this.channel.replaceChildren(...info.channels.map((c, n) => element('option', { value: n }, c.name)));
    this.channel.parentElement!.hidden = info.channels.length < 2;
    this.show();
  }

  // iso: of the look, where the view has none.
  show(iso?: number): void {
    if (!this.info) return;
    const view = this.view();
    this.channel.value = String(view.channel);
    this.look.value = String(view.look);
    const mode = this.modes.querySelector<HTMLInputElement>(`input[value="${view.mode}"]`);
    if (mode) mode.checked = true;
    this.opacity.value = String(Math.log10(view.opacity));
    const [from, to] = this.info.channels[view.channel].keptRange;
    const at = view.iso ?? iso;
    if (at !== undefined && to > from) this.iso.value = String((at - from) / (to - from));
    this.isoRow.hidden = view.mode !== 2;
    this.shading.checked = view.shading;
    this.perspective.checked = view.perspective;
    this.planes.checked = view.planes;
    this.clips.forEach((input, n) => (input.value = String(view.clip[n])));
  }
}
