// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// Which tiles of a map there are, and which of them to draw: fine ones near the eye, coarse ones far away, never more
// points than the budget.
import { Box3, Vector3 } from 'three';

export const kCells = 64;  // of a tile, a side
const kTopLevel = 15;
const kFewRoots = 8;       // of a map around the grid's origin
const kFinest = 1.5;       // [pixels] between points; finer is not seen
const kMostRequests = 6;

const name = (level, at) => `${level}/${at.join('/')}`;

/** A tile, known by its place; its points come when they are needed. */
class Tile {
  children = [];
  leaves = 0;
  revision = 0;
  points = null;          // what MapScene made of it
  loadedRevision = -1;
  isRequested = false;
  isDrawn = false;
  lastDrawn = 0;          // frame

  constructor(level, at, frame) {
    this.level = level;
    this.at = at;
    const edge = frame.edge * kCells * 2 ** level;
    this.edge = edge;
    this.cell = frame.edge * 2 ** level;
    const corner = new Vector3(...at.map((i, axis) => i * edge + frame.origin[axis] - frame.center[axis]));
    this.box = new Box3(corner, corner.clone().addScalar(edge));
  }

  /** How many points it has, or may have: a surface has a quarter of the cells at each level. */
  get size() { return this.points ? this.points.count : Math.min(this.leaves / 4 ** this.level, 3 * kCells * kCells); }
}

/** `frame`: { edge, origin, center } of the grid and the scene [m]. */
export class TileTree {
  tiles = new Map();
  roots = [];          // the coarsest
  #leaves = new Map(); // of each block
  #frame;
  #finest;
  #hasOneLevel;
  top = 0;
  #load;
  #unload;
  #requests = 0;
  #frameNumber = 0;
  #generation = 0;
  #drawn = [];

  /** `load(tile)` gives a promise of points, `unload(points)` frees them. */
  constructor(blocks, frame, source, load, unload) {
    this.#frame = frame;
    this.#finest = source.finestLevel;
    this.#hasOneLevel = source.hasOneLevel;
    this.#load = load;
    this.#unload = unload;
    if (this.#hasOneLevel) {
      this.top = this.#finest;
    } else {
      for (this.top = 2; this.top < kTopLevel; ++this.top) {
        const scale = 2 ** this.top;
        if (new Set(blocks.map(({ at }) => at.map((i) => Math.floor(i / scale)).join('/'))).size <= kFewRoots) break;
      }
    }
    this.update(blocks);
  }

  /** Blocks that are new or have changed. */
  update(blocks) {
    for (const block of blocks) {
      let child = null;
      const key = block.at.join('/');
      const grown = block.leaves - (this.#leaves.get(key) ?? 0);
      this.#leaves.set(key, block.leaves);
      for (let level = this.#finest; level <= this.top; ++level) {
        const at = this.#placeOf(block, level);
        let tile = this.tiles.get(name(level, at));
        if (!tile) {
          this.tiles.set(name(level, at), (tile = new Tile(level, at, this.#frame)));
          if (level === this.top) this.roots.push(tile);
        }
        if (child && !tile.children.includes(child)) tile.children.push(child);
        tile.leaves += grown;
        tile.revision = Math.max(tile.revision, block.revision);
        child = tile;
      }
    }
  }

  #placeOf({ at }, level) { return at.map((i) => Math.floor(i / 2 ** level)); }

  /** Everything, [m] in the scene. */
  get box() {
    const box = new Box3();
    for (const tile of this.tiles.values()) if (tile.level === this.#finest && tile.leaves > 0) box.union(tile.box);
    return box;
  }

  /**
   * The tiles to draw now, for an eye at `eye` that sees what is in `frustum`; `focal` [pixels]. Asks for those that are
   * missing, the ones that matter most first.
   */
  select(eye, frustum, focal, budget) {
    ++this.#frameNumber;
    const spacing = (tile) => (focal * tile.cell) / Math.max(tile.box.distanceToPoint(eye), tile.cell);
    const wanted = [];
    const drawn = [];
    const open = this.roots.filter((tile) => frustum.intersectsBox(tile.box));
    let cost = open.reduce((sum, tile) => sum + tile.size, 0);
    const draw = (tile) => {
      if (tile.points) drawn.push(tile);
      if (tile.loadedRevision < tile.revision) wanted.push(tile);
    };
    while (open.length > 0) {
      let most = 0;
      for (let i = 1; i < open.length; ++i) if (spacing(open[i]) > spacing(open[most])) most = i;
      const [tile] = open.splice(most, 1);
      if (tile.level === this.#finest || spacing(tile) < kFinest) { draw(tile); continue; }
      const children = tile.children.filter((child) => frustum.intersectsBox(child.box));
      const more = children.reduce((sum, child) => sum + child.size, 0) - tile.size;
      if (cost + more > budget) { draw(tile); continue; }
      const missing = children.filter((child) => !child.points);
      if (missing.length > 0) {
        draw(tile);
        wanted.push(...missing);
        continue;
      }
      cost += more;
      open.push(...children);
    }
    for (const tile of this.#drawn) tile.isDrawn = false;
    this.#drawn = drawn;
    for (const tile of drawn) [tile.isDrawn, tile.lastDrawn] = [true, this.#frameNumber];
    wanted.sort((a, b) => b.level - a.level || spacing(b) - spacing(a));
    for (const tile of wanted) this.#request(tile);
    this.#forget(2 * budget);
    return drawn;
  }

  get isComplete() { return this.#requests === 0; }

  async #request(tile) {
    if (tile.isRequested || this.#requests >= kMostRequests) return;
    tile.isRequested = true;
    ++this.#requests;
    const generation = this.#generation;
    const revision = tile.revision;
    try {
      const points = await this.#load(tile);
      if (generation !== this.#generation) return this.#unload(points);
      if (tile.points) this.#unload(tile.points);
      tile.points = points;
      tile.loadedRevision = revision;
    } catch {
      await new Promise((resolve) => setTimeout(resolve, 500));  // the server is away; it is asked again
    } finally {
      tile.isRequested = false;
      --this.#requests;
    }
  }

  /** Frees what was not drawn for longest, down to `most` points. */
  #forget(most) {
    const loaded = [...this.tiles.values()].filter((tile) => tile.points);
    let sum = loaded.reduce((points, tile) => points + tile.points.count, 0);
    if (sum <= most) return;
    loaded.sort((a, b) => a.lastDrawn - b.lastDrawn);
    for (const tile of loaded) {
      if (sum <= most || tile.lastDrawn >= this.#frameNumber || tile.level === this.top) break;
      sum -= tile.points.count;
      this.#unload(tile.points);
      tile.points = null;
      tile.loadedRevision = -1;
    }
  }

  close() {
    ++this.#generation;
    for (const tile of this.tiles.values()) if (tile.points) this.#unload(tile.points);
    this.tiles.clear();
  }
}
