// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
import { scaleOf } from './colours.js';
import { MapScene } from './map_scene.js';
import { Panel, inMetres, pieceInWords } from './panel.js';
import { openSource } from './source.js';

const source = openSource();
const scene = sceneOrWords();
let page = null;
let changes = [];
let measured = null;  // places, while distances are measured
let colour = 'height';
let sectionAt = 1;    // share of the map's height

function sceneOrWords() {
  try {
    return new MapScene(document.getElementById('map'));
  } catch (error) {
    document.getElementById('notice').textContent = 'this browser cannot draw in 3D: it has no WebGL 2';
    throw error;
  }
}

const panel = new Panel({
  colour: (mode) => { colour = mode; scene.colourBy(mode); showScale(); },
  changes: (shows) => { scene.showsChanges = shows; },
  follow: (follows) => { scene.follows = follows; },
  section: (share) => { sectionAt = share; showSection(); },
  home: (fromAbove) => scene.lookAtAll(fromAbove),
  measure: (measures) => { measured = measures ? [] : null; scene.mark([]); panel.picked(measures ? 'choose two places' : ''); },
  map: () => showMap(),
  command: async (command) => {
    panel.reply(`${command} ...`);
    try {
      panel.reply(await source.command(command));
    } catch (error) {
      panel.reply(`${command}: ${error.message}`);
    }
  },
});

function showScale() {
  const [low, high] = scene.heights;
  const versions = ['first version', panel.isLive ? 'this run' : `version ${panel.versions.at(-1)?.number ?? ''}`];
  const ends = {
    height: [`${low.toFixed(1)} m`, `${high.toFixed(1)} m`], occupancy: ['50 %', '100 %'], since: versions, seen: versions,
  };
  panel.scale(scaleOf(colour), ...ends[colour]);
}

function showSection() {
  const [low, high] = scene.heights;
  const height = low + sectionAt * (high - low);
  scene.top = sectionAt < 1 ? height : 1e9;
  panel.section(sectionAt < 1 ? `nothing above ${height.toFixed(1)} m` : 'nothing cut off');
}

async function describe() {
  page = await source.page();
  panel.describe(page);
  scene.lastVersion = (page.versions.at(-1)?.number ?? 0) + (page.live ? 1 : 0);
}

async function showMap() {
  const map = panel.map;
  panel.notice('');
  try {
    const blocks = await source.blocks(map);
    if (map !== panel.map) return;
    scene.showMap(source, map, page, blocks);
    if (blocks.length === 0) panel.notice('this map has no leaves');
    await showChanges();
  } catch (error) {
    panel.notice(error.message);
  }
}

const showAnew = () => describe().then(showMap).catch((error) => panel.notice(error.message));

async function showChanges() {
  changes = panel.hasComparison || source.hasOneLevel ? await source.changes(panel.map) : [];
  panel.pieces(changes, (change) => {
    scene.lookAtBox(change.min, change.max);
    panel.picked(pieceInWords(change));
  });
}

/** What is known of a place that was clicked. */
function inWords(picked) {
  const p_map = scene.toMap(picked.at);
  const lines = [inMetres(p_map)];
  const piece = picked.change > 0 && changes.find(({ has_come, min, max }) =>
    has_come === (picked.change === 1) && p_map.every((x, i) => x >= min[i] - picked.cell && x <= max[i] + picked.cell));
  if (piece) lines.push(`${pieceInWords(piece)}, ${piece.leaves} leaves`);
  if (picked.change === 2) {
    lines.push(`went between ${between()}; last written in ${panel.versionInWords(picked.seen)}`);
  } else {
    lines.push(`${(100 * picked.probability).toFixed(0)} % occupied`);
    if (panel.versions.length > 0 || panel.isLive) {
      lines.push(`there since ${panel.versionInWords(picked.since)}; last written in ${panel.versionInWords(picked.seen)}`);
    }
  }
  return lines.join('\n');
}

function between() {
  const [before, after] = panel.map.includes('..') ? panel.map.split('..') : ['', panel.map];
  const name = (version) => (version === '' ? 'the start of this run' : version === 'now' ? 'now' : panel.versionInWords(Number(version)));
  return `${name(before)} and ${name(after)}`;
}

function click(event) {
  const picked = scene.pick(event.offsetX, event.offsetY);
  if (!measured) return panel.picked(picked ? inWords(picked) : '');
  if (!picked) return;
  if (measured.length === 2) measured = [];
  measured.push(picked.at);
  scene.mark(measured);
  if (measured.length < 2) return panel.picked(`${inMetres(scene.toMap(picked.at))}\nchoose the other place`);
  const apart = measured[1].clone().sub(measured[0]);
  panel.picked(`${apart.length().toFixed(2)} m apart\n${Math.hypot(apart.x, apart.y).toFixed(2)} m on the flat, ` +
    `${apart.z.toFixed(2)} m in height`);
}

// A click is no drag.
let pressed = null;
scene.canvas.addEventListener('pointerdown', (event) => { pressed = [event.clientX, event.clientY]; });
scene.canvas.addEventListener('pointerup', (event) => {
  const kStill = 5;  // [pixels]
  if (pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < kStill) click(event);
  pressed = null;
});

let said = 0;
scene.onFrame = () => {
  const kPause = 500;  // [ms]
  if (performance.now() - said < kPause) return;
  said = performance.now();
  showScale();
  panel.figures(`${scene.drawnPoints.toLocaleString('en')} points, ${(1000 / scene.frameTime).toFixed(0)} frames/s`);
};

async function start() {
  for (;;) {
    try {
      await describe();
      break;
    } catch (error) {
      panel.notice(error.message);
      await new Promise((resolve) => setTimeout(resolve, 1000));
    }
  }
  await showMap();
  showSection();
  if (!page.live) {
    // Another process may change the map.
    const kLook = 5000;  // [ms]
    if (!source.hasOneLevel) setInterval(async () => {
      const { changed } = await source.status().catch(() => page);
      if (changed !== page.changed) showAnew();
    }, kLook);
    return;
  }
  let isFirst = true;
  const kChanges = 5000;  // [ms]
  setInterval(() => panel.hasComparison && panel.map === 'now' && showChanges().catch(() => {}), kChanges);
  source.listen({
    again: async () => {
      panel.notice('');
      if (!isFirst) await showAnew();
      isFirst = false;
    },
    silence: () => panel.notice('no connection; tries again'),
    blocks: (blocks) => panel.map === 'now' && scene.blocksChanged(blocks),
    status: (status) => {
      panel.status(status);
      scene.showRobot(status.believed ? status.pose : null, status.level);
    },
    scan: (buffer) => scene.showScan(buffer),
  });
}

/** For scripts. */
window.evermap = {
  scene, panel,
  get isComplete() { return scene.isSettled && scene.mapName === panel.map; },
};
start();
