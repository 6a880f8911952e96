// SPDX-License-Identifier: Apache-2.0
// The page: a link's file and view, a file that is dropped or chosen, and the view kept in the address.
import { createViewer } from './viewer';
import { fromHash, toHash } from './state';

const address = new URL(location.href);
const url = address.searchParams.get('url') ?? undefined;
const into = document.getElementById('viewer')!;
const welcome = document.getElementById('welcome')!;
const chosen = document.getElementById('file') as HTMLInputElement;

const viewer = createViewer(into, {
  url,
  view: fromHash(address.hash),
  onview: (view) => history.replaceState(null, '', `#${toHash(view)}`),
});
welcome.hidden = url !== undefined;

function open(file: File | undefined): void {
  if (!file) return;
  welcome.hidden = true;
  history.replaceState(null, '', location.pathname);
  viewer.openFile(file);
}

chosen.addEventListener('change', () => open(chosen.files?.[0]));
document.getElementById('by-link')!.addEventListener('submit', (e) => {
  e.preventDefault();
  const link = new FormData(e.target as HTMLFormElement).get('url') as string;
  location.search = `?url=${encodeURIComponent(link)}`;
});
addEventListener('dragover', (e) => {
  e.preventDefault();
  document.body.classList.add('dropping');
});
addEventListener('dragleave', () => document.body.classList.remove('dropping'));
addEventListener('drop', (e) => {
  e.preventDefault();
  document.body.classList.remove('dropping');
  open(e.dataTransfer?.files[0]);
});
addEventListener('hashchange', () => {
  Object.assign(viewer.view, fromHash(location.hash));
  viewer.refresh();
});

(window as unknown as { viewer: typeof viewer }).viewer = viewer;
