// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// node build.mjs PACKAGES PAGE: bundles src/ with the packages in PACKAGES/node_modules into one file of HTML that loads
// nothing from elsewhere.
import { createRequire } from 'node:module';
import { readFileSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const [packages, page] = process.argv.slice(2).map((path) => resolve(path));
const source = join(dirname(fileURLToPath(import.meta.url)), 'src');
const { build } = createRequire(join(packages, 'package.json'))('esbuild');

const bundle = await build({
  entryPoints: [join(source, 'main.js')],
  bundle: true,
  minify: true,
  format: 'iife',
  target: 'es2020',
  legalComments: 'eof',
  nodePaths: [join(packages, 'node_modules')],
  write: false,
});
// Neither may end the element that it stands in.
const script = bundle.outputFiles[0].text.replaceAll('</script', '<\\/script').replaceAll('<!--', '<\\!--');
const style = readFileSync(join(source, 'style.css'), 'utf8');
const html = readFileSync(join(source, 'index.html'), 'utf8')
  .replace('/*style*/', () => style)
  .replace('/*script*/', () => script);
writeFileSync(page, html);
