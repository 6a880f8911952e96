// SPDX-License-Identifier: Apache-2.0
// The engine in a worker of its own, so that the page never waits for it.
import { Engine } from './engine/engine';
import type { FromEngine, ToEngine } from './protocol';

const scope = self as unknown as {
  postMessage(message: FromEngine, transfer: Transferable[]): void;
  onmessage: ((e: MessageEvent<ToEngine>) => void) | null;
};
const engine = new Engine((message, transfer) => scope.postMessage(message, transfer ?? []));
scope.onmessage = (e) => void engine.hear(e.data);
