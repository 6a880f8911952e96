// SPDX-License-Identifier: Apache-2.0
// Saves what is seen: a picture as PNG, the series as WebM.

export function composed(image: ImageBitmap, overlay: HTMLCanvasElement): HTMLCanvasElement {
  const canvas = document.createElement('canvas');
  canvas.width = image.width;
  canvas.height = image.height;
  compose(canvas, image, overlay);
  return canvas;
}

export function compose(canvas: HTMLCanvasElement, image: ImageBitmap, overlay: HTMLCanvasElement): void {
  const c = canvas.getContext('2d')!;
  c.drawImage(image, 0, 0, canvas.width, canvas.height);
  c.drawImage(overlay, 0, 0, canvas.width, canvas.height);
  image.close();
}

export function download(blob: Blob, name: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

export async function savePicture(canvas: HTMLCanvasElement, name: string): Promise<void> {
  const blob = await new Promise<Blob | null>((done) => canvas.toBlob(done, 'image/png'));
  if (blob) download(blob, name);
}

// Records pictures that come one after the other at so many a second.
export class Film {
  private readonly parts: Blob[] = [];
  private readonly recorder: MediaRecorder;

  constructor(readonly canvas: HTMLCanvasElement) {
    const stream = canvas.captureStream();
    const types = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm'];
    const mimeType = types.find((t) => MediaRecorder.isTypeSupported(t));
    const bitsPerSecond = 12e6;
    this.recorder = new MediaRecorder(stream, { mimeType, videoBitsPerSecond: bitsPerSecond });
    this.recorder.ondataavailable = (e) => this.parts.push(e.data);
    this.recorder.start();
    this.recorder.pause();
  }

  // Shows what the canvas holds for some milliseconds; while the next picture is made the film stands still.
  async add(milliseconds: number): Promise<void> {
    this.recorder.resume();
    await new Promise((go) => setTimeout(go, milliseconds));
    this.recorder.pause();
  }

  async end(): Promise<Blob> {
    const stopped = new Promise((done) => (this.recorder.onstop = done));
    this.recorder.stop();
    await stopped;
    return new Blob(this.parts, { type: 'video/webm' });
  }
}
