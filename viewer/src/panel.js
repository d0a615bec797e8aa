// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// What can be set, and what is said in words.

const byId = (id) => document.getElementById(id);
const kThisRun = 65535;

export const inTime = (seconds) => new Date(1000 * seconds).toISOString().replace('T', ' ').slice(0, 16) + ' UTC';
export const inMetres = (p) => p.map((x) => x.toFixed(2)).join('  ') + ' m';

export class Panel {
  versions = [];
  isLive = false;
  map = 'now';    // what is shown: `now`, a version's number, or two of these

  /** `on`: what to do when something is set. */
  constructor(on) {
    this.on = on;
    byId('fold').onclick = () => this.fold();
    if (matchMedia('(max-width: 600px)').matches) this.fold();
    byId('colour').onchange = () => on.colour(byId('colour').value);
    byId('changes').onchange = () => on.changes(byId('changes').checked);
    byId('follow').onchange = () => on.follow(byId('follow').checked);
    byId('section').oninput = () => on.section(Number(byId('section').value) / 1000);
    byId('home').onclick = () => on.home(false);
    byId('above').onclick = () => on.home(true);
    byId('measure').onclick = () => this.measure();
    byId('version').onchange = byId('base').onchange = () => this.#choose();
    byId('version').oninput = () => this.#say(this.#chosen());
    for (const button of document.querySelectorAll('#commands button')) {
      button.onclick = () => on.command(button.dataset.command);
    }
    addEventListener('keydown', (event) => this.#key(event));
  }

  #key(event) {
    if (event.target.matches('input, select') || event.ctrlKey || event.altKey || event.metaKey) return;
    const press = (id) => byId(id).click();
    const step = (by) => {
      byId('version').value = Number(byId('version').value) + by;
      this.#choose();
    };
    const colour = (i) => {
      byId('colour').selectedIndex = i;
      byId('colour').onchange();
    };
    const keys = {
      c: () => press('changes'), f: () => press('follow'), h: () => press('home'), t: () => press('above'),
      m: () => press('measure'), p: () => this.fold(), '[': () => step(-1), ']': () => step(1),
      1: () => colour(0), 2: () => colour(1), 3: () => colour(2), 4: () => colour(3),
    };
    keys[event.key.toLowerCase()]?.();
  }

  fold() {
    byId('fold').setAttribute('aria-expanded', !document.body.classList.toggle('folded'));
  }

  measure() {
    const measures = document.body.classList.toggle('measuring');
    byId('measure').setAttribute('aria-pressed', measures);
    this.on.measure(measures);
  }

  // ---- Versions ----

  describe(page) {
    const isFirst = this.versions.length === 0 && byId('name').textContent === 'evermap';
    this.versions = page.versions;
    this.isLive = page.live;
    byId('name').textContent = page.name;
    document.title = `${page.name} - evermap`;
    byId('robot').hidden = !page.live;
    byId('history').hidden = page.versions.length === 0;
    // Places of the slider: the versions, then now.
    byId('version').max = page.versions.length;
    byId('base').replaceChildren(new Option(page.live ? 'the start of this run' : 'nothing', ''),
      ...page.versions.map((version) => new Option(`version ${version.number}`, version.number)));
    if (isFirst) this.map = page.shown;
    const [after, before] = this.map.split('..').reverse();
    const place = page.versions.findIndex((version) => String(version.number) === after);
    byId('version').value = place < 0 ? page.versions.length : place;
    byId('base').value = before ?? '';
    this.#say(after);
  }

  #chosen() { return this.versions[Number(byId('version').value)]?.number.toString() ?? 'now'; }

  #choose() {
    const base = byId('base').value;
    const after = this.#chosen();
    this.map = base && base !== after ? `${base}..${after}` : after;
    this.#say(after);
    this.on.map(this.map);
  }

  #say(name) {
    const version = this.versions.find(({ number }) => String(number) === name);
    byId('version-words').textContent = version
      ? `${version.number}${version.tags.map((tag) => ` (${tag})`).join('')}: ${inTime(version.time)}, ${version.what}`
      : 'now';
  }

  versionInWords(number) {
    if (number === kThisRun) return 'this run';
    const version = this.versions.find((known) => known.number === number);
    if (version) return `version ${number}, ${inTime(version.time)}`;
    return number === 0 ? 'the first version' : `version ${number}`;
  }

  get hasComparison() { return this.map.includes('..') || (this.isLive && this.map === 'now'); }

  // ---- What is said ----

  scale(bytes, low, high) {
    const context = byId('scale').getContext('2d');
    context.putImageData(new ImageData(new Uint8ClampedArray(bytes), 256, 1), 0, 0);
    byId('scale-low').textContent = low;
    byId('scale-high').textContent = high;
  }
  section(words) { byId('section-words').textContent = words; }
  notice(words) { byId('notice').textContent = words; }
  reply(words) { byId('reply').textContent = words; }
  figures(words) { byId('figures').textContent = words; }

  status(status) {
    byId('state').hidden = false;
    byId('state').textContent = status.state;
    byId('state').dataset.level = status.level;
    byId('why').textContent = status.message === status.state ? '' : status.message;
    byId('where').textContent = status.pose ? inMetres(status.pose.slice(0, 3)) : '';
  }

  pieces(changes, look) {
    byId('pieces').hidden = changes.length === 0;
    const largest = [...changes].sort((a, b) => b.leaves - a.leaves).slice(0, 50);
    byId('piece-list').replaceChildren(...largest.map((change) => {
      const item = document.createElement('li');
      const button = document.createElement('button');
      button.className = change.has_come ? 'came' : 'went';
      button.textContent = pieceInWords(change);
      button.title = `${change.leaves} leaves`;
      button.onclick = () => look(change);
      item.append(button);
      return item;
    }));
  }

  picked(words) {
    byId('picked').hidden = !words;
    byId('picked').textContent = words;
  }
}

export function pieceInWords(change) {
  const size = change.min.map((x, i) => (change.max[i] - x).toFixed(1));
  return `${change.has_come ? 'came' : 'went'}: ${size.join(' x ')} m`;
}
