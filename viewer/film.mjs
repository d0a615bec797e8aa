// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// node film.mjs PROGRAM PACKAGES FOLDER: a robot drives through the quarry, `serve` keeps the map, and a browser looks on; makes
// the pictures of docs/live.md in FOLDER, and says how soon what changed was drawn.
import { execFileSync, spawn } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { firstPose, isComplete, launch } from './browser.mjs';

const [program, packages, pictures] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), 'evermap-film-'));
const domain = String(101 + (process.pid % 100));
const kSpeed = 0.5;  // the browser draws without a graphics card, on the processors that serve the map
const kLoop = 600;   // scans
const kCut = [250, 254];  // scans that are cut down to a slit ahead
const kSlit = 0.004;      // [rad] to either side
const pause = (seconds) => new Promise((resolve) => setTimeout(resolve, 1000 * seconds));
const evermap = (...args) => execFileSync(program, args, { stdio: ['ignore', 'ignore', 'inherit'] });

mkdirSync(pictures, { recursive: true });
const run = join(folder, 'run');
const map = join(folder, 'quarry.evm');
evermap('simulate', 'quarry', '-o', run, '--scans', String(kLoop));
evermap('import', join(run, 'survey.ply'), '-r', '0.4', '-o', map);
for (const name of readdirSync(join(run, 'scans')).sort().slice(...kCut)) {
  const file = join(run, 'scans', name);
  const bytes = readFileSync(file);
  const data = bytes.indexOf('DATA binary\n') + 'DATA binary\n'.length;
  const header = bytes.subarray(0, data).toString();
  const count = Number(header.match(/POINTS (\d+)/)[1]);
  const size = (bytes.length - data) / count;  // [bytes] of a point
  const kept = [];
  for (let at = data; at < bytes.length; at += size) {
    if (Math.abs(Math.atan2(bytes.readFloatLE(at + 4), bytes.readFloatLE(at))) < kSlit) kept.push(bytes.subarray(at, at + size));
  }
  writeFileSync(file, Buffer.concat([Buffer.from(header.replaceAll(String(count), String(kept.length))), ...kept]));
}

const start = firstPose(join(run, 'poses.txt'));
const server = spawn(program, ['serve', map, '--local', '--domain', domain, '--port', '0', '--initial-pose', start],
  { stdio: ['ignore', 'pipe', 'inherit'] });
const url = await new Promise((resolve) => server.stdout.on('data', (data) => {
  const said = String(data).match(/page +(\S+)/);
  if (said) resolve(said[1]);
}));
const browser = await launch(packages);
const page = await browser.newPage({ viewport: { width: 1000, height: 600 } });
const opened = performance.now();
await page.goto(url);
const complete = async () => { while (!(await isComplete(page))) await pause(0.05); };
while (!(await page.evaluate('window.evermap?.scene.drawnPoints > 0'))) await pause(0.02);
console.log(`the first picture of the map is there ${((performance.now() - opened) / 1000).toFixed(1)} s after the page was asked for`);
const look = (target, offset) => page.evaluate(`evermap.scene.look(evermap.scene.toScene(${JSON.stringify(target)}),
  evermap.scene.camera.position.clone().set(${offset.join(',')}))`);
const keep = async (name) => { await page.screenshot({ path: join(pictures, name), type: 'jpeg', quality: 80 }); };

const kBelt = [13.5, 12.4, 2];
await look(kBelt, [-22, -30, 22]);
await pause(1);
await complete();
await keep('live_1_before.jpg');
const player = spawn(program, ['play', join(run, 'scans'), '--odometry', join(run, 'poses.txt'), '--local', '--domain', domain,
  '--speed', String(kSpeed)], { stdio: 'ignore' });
const played = new Promise((resolve) => player.on('exit', resolve));
const clouds = () => page.evaluate('fetch("/api/status").then((r) => r.json()).then((s) => Number(s.values?.["clouds used"] ?? 0))');
const state = () => page.evaluate('document.getElementById("state").textContent');
while (await clouds() < 100) await pause(0.2);
await page.evaluate('evermap.scene.lookAtAll()');
await pause(1);
await keep('live_2_drive.jpg');
while (await state() !== 'degraded' && player.exitCode === null) await pause(0.05);
await keep('live_3_degraded.jpg');
while (await state() !== 'tracking' && player.exitCode === null) await pause(0.1);
await pause(3);
await keep('live_4_recovered.jpg');
await played;
await look(kBelt, [-22, -30, 22]);
await pause(7);
await complete();
await keep('live_5_grown.jpg');
// The container that stood there in the survey alone.
const kContainer = [-88, -20];
const gone = await page.evaluate(`fetch('/api/maps/now/changes').then((r) => r.json()).then((all) => all.find(({ has_come, min, max }) =>
  !has_come && ${JSON.stringify(kContainer)}.every((x, i) => min[i] < x && x < max[i])))`);
if (gone) {
  await page.evaluate(`evermap.scene.lookAtBox(${JSON.stringify(gone.min)}, ${JSON.stringify(gone.max)})`);
  await pause(1);
  await complete();
  await keep('live_6_gone.jpg');
} else {
  console.log('the container is there still');
}
await browser.close();

// How soon a page has what changed: from the message that names a block to its points, while nothing is drawn here.
const quiet = await launch(packages);
const listener = await quiet.newPage();
await listener.goto(`${url}api/status`);
await listener.evaluate(`(() => {
  window.delays = [];
  const socket = new WebSocket('ws://' + location.host + '/api/live');
  const changed = new Map();  // blocks to their times
  const fetchAll = async () => {
    for (;;) {
      const [next] = changed;
      if (!next) { await new Promise((resolve) => setTimeout(resolve, 5)); continue; }
      const [at, begin] = next;
      changed.delete(at);
      await (await fetch('/api/maps/now/tiles/0/' + at)).arrayBuffer();
      window.delays.push(performance.now() - begin);
    }
  };
  for (let i = 0; i < 6; ++i) fetchAll();
  socket.onmessage = ({ data }) => {
    const blocks = typeof data === 'string' ? JSON.parse(data).blocks ?? [] : [];
    for (const block of blocks) {
      const at = block.slice(0, 3).join('/');
      if (!changed.has(at)) changed.set(at, performance.now());
    }
  };
})()`);
execFileSync(program, ['play', join(run, 'scans'), '--odometry', join(run, 'poses.txt'), '--local', '--domain', domain, '--duration', '20'],
  { stdio: 'inherit' });
const delays = (await listener.evaluate('window.delays')).sort((a, b) => a - b);
const at = (share) => delays[Math.floor(share * (delays.length - 1))]?.toFixed(0);
console.log(`${delays.length} blocks that changed were there again, half of them within ${at(0.5)} ms, 95 % within ${at(0.95)} ms`);
await quiet.close();
server.kill('SIGTERM');
await new Promise((resolve) => server.on('exit', resolve));
rmSync(folder, { recursive: true });
