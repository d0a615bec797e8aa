// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// node frames.mjs URL PACKAGES: how many frames a second of a served map Chromium draws while the eye goes round it, drawn by the
// processor; every four seconds.
import { isComplete, launch } from './browser.mjs';

const [url, packages] = process.argv.slice(2);
const browser = await launch(packages);
const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
await page.goto(url);
while (!(await isComplete(page))) await new Promise((resolve) => setTimeout(resolve, 50));
for (let turn = 0; turn < 4; ++turn) {
  const frames = await page.evaluate(`new Promise((done) => {
    const { scene } = evermap;
    const begin = performance.now();
    let frames = 0;
    const next = () => {
      scene.camera.position.applyAxisAngle(scene.camera.up, 0.01);
      scene.controls.update();
      scene.touch();
      ++frames;
      if (performance.now() - begin > 4000) done(frames / 4);
      else requestAnimationFrame(next);
    };
    next();
  })`);
  console.log(`${frames} frames/s of ${await page.evaluate('evermap.scene.drawnPoints')} points`);
}
await browser.close();
