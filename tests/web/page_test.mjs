// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// node page_test.mjs PROGRAM PACKAGES [FOLDER]: the page in Chromium, on a yard whose box vanished; with FOLDER, pictures are
// kept there. Exit code 77 where there is no Chromium.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { chromium, firstPose, isComplete, launch } from '../../viewer/browser.mjs';

const [program, packages, pictures] = process.argv.slice(2);
if (!chromium) process.exit(77);
const folder = mkdtempSync(join(tmpdir(), 'evermap-page-'));
const inFolder = (name) => join(folder, name);
const domain = String(101 + (process.pid % 100));
const kPatience = 60_000;  // [ms]

let browser;
const servers = new Set();

function evermap(...args) { return execFileSync(program, args, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] }); }

/** A server that has said where its page is. */
function serve(...args) {
  const process = spawn(program, args, { stdio: ['ignore', 'pipe', 'pipe'] });
  servers.add(process);
  let said = '';
  return new Promise((resolve, reject) => {
    process.stdout.on('data', (data) => {
      said += data;
      const url = said.match(/page +(\S+)/);
      if (url) resolve({ process, url: url[1] });
    });
    process.stderr.on('data', (data) => { said += data; });
    process.on('exit', () => { servers.delete(process); reject(new Error(said)); });
  });
}
async function stop({ process }) {
  const ended = new Promise((resolve) => process.once('exit', resolve));
  process.kill('SIGTERM');
  await ended;
}

async function until(holds, what) {
  const end = Date.now() + kPatience;
  while (!(await holds())) {
    assert.ok(Date.now() < end, `${what} did not happen`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

/** A page on which all is drawn. What goes wrong in it fails the test. */
async function open(t, url, options = {}) {
  const context = await browser.newContext({ viewport: { width: 800, height: 600 }, ...options });
  t.after(() => context.close());
  const page = await context.newPage();
  page.on('pageerror', (error) => assert.fail(error));
  page.requests = [];
  page.on('request', (request) => page.requests.push(request.url()));
  await page.goto(url);
  await complete(page);
  return page;
}
const complete = (page) => until(() => isComplete(page), 'the picture');
const keep = (page, name) => pictures && page.screenshot({ path: join(pictures, name) });

/** How many of the drawn pixels are of a kind. */
const pixels = (page, kind) => page.evaluate(`(() => {
  const bytes = evermap.scene.pixels();
  const kinds = {
    drawn: (r, g, b) => Math.abs(r - 0x10) + Math.abs(g - 0x15) + Math.abs(b - 0x1c) > 20,
    orange: (r, g, b) => r > 90 && r > 1.25 * g && g > 2 * b,
    blue: (r, g, b) => b > 90 && b > 1.15 * g && g > 1.6 * r,
  };
  let count = 0;
  for (let i = 0; i < bytes.length; i += 4) count += kinds[${JSON.stringify(kind)}](bytes[i], bytes[i + 1], bytes[i + 2]);
  return count;
})()`);
const choose = (page, id, value) => page.evaluate(`(() => {
  const control = document.getElementById(${JSON.stringify(id)});
  control.value = ${JSON.stringify(value)};
  control.dispatchEvent(new Event('input'));
  control.dispatchEvent(new Event('change'));
})()`);
const text = (page, id) => page.evaluate(`document.getElementById(${JSON.stringify(id)}).textContent`);

before(async () => {
  if (pictures) mkdirSync(pictures, { recursive: true });
  evermap('simulate', 'yard', '-o', inFolder('yard'));
  evermap('import', inFolder('yard/survey.ply'), '-r', '0.2', '-o', inFolder('yard.evm'));
  evermap('import', inFolder('yard/survey.ply'), '-r', '0.2', '-o', inFolder('live.evm'));
  evermap('update', inFolder('yard.evm'), inFolder('yard/scans'), '--poses', inFolder('yard/poses.txt'), '-o', inFolder('yard.evm'),
    '--report', inFolder('report'));
  browser = await launch(packages);
});
after(async () => {
  await browser?.close();
  for (const process of servers) process.kill('SIGKILL');
  rmSync(folder, { recursive: true });
});

test('draws a map, and what changed where the box vanished', async (t) => {
  const server = await serve('view', inFolder('yard.evm'), '1..now', '--port', '0');
  t.after(() => stop(server));
  const page = await open(t, server.url);
  assert.ok(await pixels(page, 'drawn') > 0.05 * 800 * 600);
  await keep(page, 'changes.png');
  const largest = await page.evaluate(`fetch('/api/maps/1..now/changes').then((r) => r.json())
    .then((all) => all.filter(({ has_come }) => !has_come).sort((a, b) => b.leaves - a.leaves)[0])`);
  await page.evaluate(`evermap.scene.lookAtBox(${JSON.stringify(largest.min)}, ${JSON.stringify(largest.max)})`);
  await complete(page);
  const orange = await pixels(page, 'orange');
  assert.ok(orange > 2000, `${orange} pixels`);
  await keep(page, 'vanished.png');

  // Without changes, what went is not there; in the version before, it stands, in the colour of its height.
  await page.keyboard.press('c');
  await complete(page);
  assert.ok(await pixels(page, 'orange') < 0.1 * orange);
  await page.keyboard.press('c');
  await choose(page, 'base', '');
  await choose(page, 'version', '0');
  await until(async () => (await text(page, 'version-words')).startsWith('1: '), 'the version');
  await complete(page);
  assert.ok(await pixels(page, 'orange') < 0.1 * orange);
  assert.equal(await page.evaluate('evermap.panel.map'), '1');
  await page.keyboard.press(']');
  await complete(page);
  assert.equal(await page.evaluate('evermap.panel.map'), '2');
});

test('a click tells what, when and how sure; two tell how far', async (t) => {
  const server = await serve('view', inFolder('yard.evm'), '1..now', '--port', '0');
  t.after(() => stop(server));
  const page = await open(t, server.url);
  const canvas = page.locator('#map');
  await canvas.click({ position: { x: 300, y: 330 } });
  await until(async () => (await text(page, 'picked')) !== '', 'words');
  assert.match(await text(page, 'picked'), /m\n(.*\n)?\d+ % occupied\nthere since .*; last written in /);
  await page.locator('#piece-list button.went').first().click();
  await complete(page);
  await canvas.click({ position: { x: 400, y: 300 } });
  await until(async () => /went: [\d.]+ x [\d.]+ x [\d.]+ m, \d+ leaves\nwent between version 1, .* and now/.test(await text(page, 'picked')), 'what went');
  await page.keyboard.press('m');
  await canvas.click({ position: { x: 300, y: 330 } });
  await canvas.click({ position: { x: 420, y: 330 } });
  assert.match(await text(page, 'picked'), /^\d+\.\d\d m apart\n/);
  await keep(page, 'measured.png');
});

test('a section cuts off what is above', async (t) => {
  const server = await serve('view', inFolder('yard.evm'), '--port', '0');
  t.after(() => stop(server));
  const page = await open(t, server.url);
  await page.keyboard.press('t');
  await complete(page);
  const whole = await pixels(page, 'drawn');
  await choose(page, 'section', '100');
  await complete(page);
  const below = await pixels(page, 'drawn');
  assert.ok(below < 0.95 * whole && below > 0, `${below} of ${whole}`);
  for (const mode of ['occupancy', 'since', 'seen', 'height']) {
    await choose(page, 'colour', mode);
    await complete(page);
    assert.ok(await pixels(page, 'drawn') > 0, mode);
  }
});

test('a report opens from disk and asks nobody', async (t) => {
  const url = pathToFileURL(inFolder('report/viewer.html')).href;
  const page = await open(t, url);
  assert.ok(await pixels(page, 'drawn') > 0.05 * 800 * 600);
  assert.ok(await pixels(page, 'orange') > 20);
  assert.deepEqual(page.requests.filter((request) => !request.startsWith('data:')), [url]);
  const server = await serve('view', inFolder('yard.evm'), inFolder('report'), '--port', '0');
  t.after(() => stop(server));
  await open(t, server.url);
});

test('on a phone held upright the map has the screen', async (t) => {
  const server = await serve('view', inFolder('yard.evm'), '1..now', '--port', '0');
  t.after(() => stop(server));
  const page = await open(t, server.url, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 });
  assert.equal(await page.evaluate('document.documentElement.scrollWidth'), 390);
  assert.ok(await page.evaluate("document.body.classList.contains('folded')"));
  await page.locator('#map').tap({ position: { x: 195, y: 430 } });
  await until(async () => (await text(page, 'picked')) !== '', 'words');
  await page.locator('#fold').tap();
  await page.locator('#above').tap();
  await complete(page);
  assert.ok(await page.evaluate("document.getElementById('panel').getBoundingClientRect().right") <= 390);
  await keep(page, 'phone.png');
});

test('others open the page over TLS, by its token', async (t) => {
  const server = await serve('view', inFolder('yard.evm'), '--listen', '0.0.0.0', '--port', '0');
  t.after(() => stop(server));
  const url = new URL(server.url);
  url.hostname = 'localhost';
  const page = await open(t, url.href, { ignoreHTTPSErrors: true });
  assert.equal(await page.evaluate('location.href'), `${url.origin}/`);  // the token is in no address that could be passed on
  assert.equal(await page.evaluate('document.cookie'), '');              // nor where scripts could read it
  const stranger = await browser.newContext({ ignoreHTTPSErrors: true });
  t.after(() => stranger.close());
  const refused = await (await stranger.newPage()).goto(`${url.origin}/`);
  assert.equal(refused.status(), 401);
});

test('another site cannot ask, nor listen', async (t) => {
  const server = await serve('view', inFolder('yard.evm'), '--port', '0');
  t.after(() => stop(server));
  const foreign = createServer((_, response) => response.end('<title>elsewhere</title>')).listen(0, '127.0.0.1');
  t.after(() => foreign.close());
  await until(() => foreign.address() !== null, 'the other site');
  const context = await browser.newContext();
  t.after(() => context.close());
  const page = await context.newPage();
  await page.goto(`http://127.0.0.1:${foreign.address().port}/`);
  assert.equal(await page.evaluate(`fetch('${server.url}api/page').then(() => 'read', () => 'refused')`), 'refused');
  assert.equal(await page.evaluate(`fetch('${server.url}api/command', { method: 'POST', mode: 'no-cors', body: '{"command":"save"}' })
    .then((r) => r.type, () => 'refused')`), 'opaque');  // sent, but refused by the server: see below
  const socket = server.url.replace('http', 'ws') + 'api/live';
  assert.equal(await page.evaluate(`new Promise((done) => {
    const socket = new WebSocket('${socket}');
    socket.onopen = () => done('open');
    socket.onerror = () => done('refused');
  })`), 'refused');
  const answer = await fetch(`${server.url}api/command`, { method: 'POST', body: '{"command":"save"}', headers: { Origin: 'http://127.0.0.1:1' } });
  assert.equal(answer.status, 403);
});

test('follows a robot, and its server when that begins anew', async (t) => {
  const start = firstPose(inFolder('yard/poses.txt'));
  const run = (port) => serve('serve', inFolder('live.evm'), '--local', '--domain', domain, '--initial-pose', start, '--port', port);
  let server = await run('0');
  const page = await open(t, server.url, { viewport: { width: 800, height: 480 } });
  const player = spawn(program, ['play', inFolder('yard/scans'), '--odometry', inFolder('yard/poses.txt'), '--local', '--domain', domain,
    '--speed', '0.5'], { stdio: 'ignore' });
  t.after(() => player.kill('SIGKILL'));
  await until(() => page.evaluate('evermap.scene.robotPlaces > 10'), 'a way');
  await until(async () => /\d m$/.test(await text(page, 'where')), 'a place');
  await until(() => page.evaluate('[...evermap.scene.tree.tiles.values()].some((tile) => tile.loadedRevision > 0)'), 'a change');
  await page.locator('#commands button[data-command="save"]').click();
  await until(async () => (await text(page, 'reply')) === 'save: done', 'the reply');
  await keep(page, 'live.png');
  const { port } = new URL(server.url);
  await stop(server);
  await until(async () => (await text(page, 'notice')).startsWith('no connection'), 'the notice');
  await until(async () => {
    try { server = await run(port); return true; } catch { return false; }
  }, 'the new server');
  t.after(() => stop(server));
  await until(async () => (await text(page, 'notice')) === '', 'the connection');
  await complete(page);
  assert.ok(await page.evaluate('evermap.panel.versions.length') >= 2);
});
