// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// Chromium for the scripts and tests that look at the page.
import { existsSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { resolve } from 'node:path';

/** Where it is; undefined when there is none. */
export const chromium = ['/usr/bin/chromium', '/usr/bin/google-chrome'].find((path) => existsSync(path));

/** Drawn by the processor; driven by the Playwright in PACKAGES/node_modules. */
export function launch(packages) {
  return createRequire(resolve(packages, 'package.json'))('playwright-core').chromium.launch({
    executablePath: chromium, args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });
}

/** Whether all that is to be seen is drawn. */
export const isComplete = (page) => page.evaluate('Boolean(window.evermap?.isComplete)');

/** The first pose of a TUM file, as --initial-pose takes it. */
export const firstPose = (file) => readFileSync(file, 'utf8').split('\n').find((line) => /^\d/.test(line)).split(' ').slice(1).join(' ');
