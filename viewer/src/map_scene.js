// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// Draws the map's tiles, the robot, its scan and what was measured.
import {
  BufferAttribute, BufferGeometry, DataTexture, Frustum, GLSL3, Group, InterleavedBuffer, InterleavedBufferAttribute, Line,
  LineBasicMaterial, Matrix4, Mesh, MeshBasicMaterial, ConeGeometry, PerspectiveCamera, Points, PointsMaterial, Quaternion,
  RawShaderMaterial, Scene, Sphere, SphereGeometry, Vector3, WebGLRenderer,
} from 'three';
import { MapControls } from 'three/addons/controls/MapControls.js';
import { scaleOf } from './colours.js';
import { TileTree, kCells } from './tile_tree.js';

const kModes = { height: 0, occupancy: 1, since: 2, seen: 3 };
const kStateColours = { 0: 0x56b4e9, 1: 0xe69f00, 2: 0xd55e00 };
const kMostPoints = 6_000_000;
const kWay = 20000;  // places of the robot that are kept

const kVertexShader = `
  precision highp float;
  in vec3 position;       // in the tile, 0 to 1
  in vec2 age;            // version since which it is there, and that wrote it last
  in vec3 normal;
  in vec2 state;          // probability, change
  uniform mat4 modelMatrix, viewMatrix, projectionMatrix;
  uniform float cell, focal, mode, low, high, lastVersion, top;
  uniform bool showsChanges;
  uniform sampler2D scale;
  out vec3 colour;
  void main() {
    vec4 place = modelMatrix * vec4(position, 1.0);
    vec4 seen = viewMatrix * place;
    gl_Position = projectionMatrix * seen;
    float change = state.y * 255.0;
    bool went = change > 1.5;
    if (place.z > top || (went && !showsChanges)) {
      gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
      return;
    }
    gl_PointSize = clamp(1.7 * cell * focal / max(-seen.z, 0.1), 1.5, 64.0);
    float version = mode < 2.5 ? age.x : age.y;
    float value = mode < 0.5 ? (place.z - low) / (high - low)
                : mode < 1.5 ? (state.x - 0.5) * 2.0
                : version > 65534.5 ? 1.0 : version / lastVersion;
    colour = texture(scale, vec2(clamp(value, 0.002, 0.998), 0.5)).rgb;
    if (showsChanges && change > 0.5) colour = went ? vec3(0.902, 0.624, 0.0) : vec3(0.337, 0.706, 0.914);
    // A light from above and beside; what side a surface shows is not known.
    float light = abs(dot(normalize(normal + vec3(1e-6)), normalize(vec3(0.35, 0.2, 0.9))));
    colour *= 0.5 + 0.5 * light;
  }`;
const kFragmentShader = `
  precision mediump float;
  in vec3 colour;
  out vec4 drawn;
  void main() {
    vec2 off = gl_PointCoord - 0.5;
    if (dot(off, off) > 0.25) discard;
    drawn = vec4(colour, 1.0);
  }`;

export class MapScene {
  tree = null;
  mapName = null;
  budget = matchMedia('(max-width: 600px)').matches ? 300_000 : 800_000;  // points
  frameTime = 16;  // [ms]
  drawnPoints = 0;
  follows = false;
  onFrame = () => {};

  #frame = null;
  #scene = new Scene();
  #tiles = new Group();
  #robot = new Group();
  #body = new Mesh(new ConeGeometry(0.6, 2, 12), new MeshBasicMaterial({ color: kStateColours[0] }));
  #way = new Line(new BufferGeometry(), new LineBasicMaterial({ color: 0xcc79a7 }));
  #scan = new Points(new BufferGeometry(), new PointsMaterial({ color: 0xf0e442, size: 2, sizeAttenuation: false }));
  #marks = new Group();
  #places = new Float32Array(3 * kWay);
  #placeCount = 0;
  #told = '';  // of the robot
  #isDirty = true;
  #isLoading = false;  // dirty, but only by tiles that came
  #last = 0;
  #isMoving = false;  // the frame before was one of a movement
  #timed = [];       // [ms] frames one after the other, since the budget changed
  #resolution = 1;   // share of the screen's
  #isStill = false;  // nothing moves: there is time for detail
  #stillBudget = 0;

  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: false, powerPreference: 'high-performance' });
    this.renderer.setClearColor(0x10151c);
    this.camera = new PerspectiveCamera(60, 1, 0.1, 1e5);
    this.camera.up.set(0, 0, 1);
    this.controls = new MapControls(this.camera, canvas);
    this.controls.zoomToCursor = true;
    this.controls.maxPolarAngle = 0.97 * Math.PI;
    this.controls.listenToKeyEvents(canvas);
    this.controls.addEventListener('change', () => this.touch());
    this.material = new RawShaderMaterial({
      glslVersion: GLSL3, vertexShader: kVertexShader, fragmentShader: kFragmentShader,
      uniforms: {
        cell: { value: 1 }, focal: { value: 1 }, mode: { value: 0 }, low: { value: 0 }, high: { value: 1 },
        lastVersion: { value: 1 }, top: { value: 1e9 }, showsChanges: { value: true }, scale: { value: null },
      },
    });
    this.colourBy('height');
    this.#body.rotation.z = -Math.PI / 2;  // the cone's tip is ahead, along x
    this.#robot.add(this.#body);
    for (const object of [this.#way, this.#scan]) object.frustumCulled = false;
    this.#way.geometry.setAttribute('position', new BufferAttribute(this.#places, 3));
    this.#way.geometry.setDrawRange(0, 0);
    this.#robot.visible = false;
    this.#scene.add(this.#tiles, this.#robot, this.#way, this.#scan, this.#marks);
    requestAnimationFrame((now) => this.#draw(now));
  }

  /** Whether all that is to be seen is drawn. */
  get isSettled() { return this.drawnPoints > 0 && this.#isStill && !this.#isDirty && this.tree.isComplete; }

  /** Something is to be drawn anew. */
  touch() { this.#isDirty = true; this.#isLoading = false; }

  // ---- What is shown ----

  /** `page`: grid and frame of the map. The camera stays where it was if a map was shown before. */
  showMap(source, name, page, blocks) {
    const isFirst = this.#frame === null;
    if (isFirst) {
      const center = [0, 0, 0];
      for (const { at } of blocks) for (let i = 0; i < 3; ++i) center[i] += (at[i] + 0.5) / blocks.length;
      this.#frame = { origin: page.origin, edge: page.edge, center: center.map((x, i) => x * kCells * page.edge + page.origin[i]) };
    }
    this.tree?.close();
    this.mapName = name;
    this.drawnPoints = 0;
    this.tree = new TileTree(blocks, this.#frame, source, async (tile) => {
      const points = this.#pointsOf(await source.tile(name, tile.level, tile.at), tile);
      this.#isLoading ||= !this.#isDirty;
      this.#isDirty = true;
      return points;
    }, (points) => points.geometry.dispose());
    const box = this.tree.box;
    if (!box.isEmpty()) [this.material.uniforms.low.value, this.material.uniforms.high.value] = [box.min.z, box.max.z];
    if (isFirst) this.lookAtAll();
    this.touch();
  }

  /** What colours by height span, from the tiles that are there: boxes reach farther than surfaces. */
  #fitHeights() {
    let low = Infinity;
    let high = -Infinity;
    for (const tile of this.tree.roots) {
      if (!tile.points) continue;
      low = Math.min(low, tile.box.min.z + tile.points.low * tile.edge);
      high = Math.max(high, tile.box.min.z + tile.points.high * tile.edge);
    }
    if (low < high) [this.material.uniforms.low.value, this.material.uniforms.high.value] = [low, high];
  }
  /** [m] in the map */
  get heights() { return ['low', 'high'].map((end) => this.material.uniforms[end].value + (this.#frame?.center[2] ?? 0)); }

  #pointsOf(buffer, tile) {
    const count = buffer.byteLength / 16;
    const shorts = new InterleavedBuffer(new Uint16Array(buffer), 8);
    const signed = new InterleavedBuffer(new Int8Array(buffer), 16);
    const bytes = new InterleavedBuffer(new Uint8Array(buffer), 16);
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new InterleavedBufferAttribute(shorts, 3, 0, true));
    geometry.setAttribute('age', new InterleavedBufferAttribute(shorts, 2, 3, false));
    geometry.setAttribute('normal', new InterleavedBufferAttribute(signed, 3, 10, true));
    geometry.setAttribute('state', new InterleavedBufferAttribute(bytes, 2, 13, true));
    geometry.boundingSphere = new Sphere(new Vector3(0.5, 0.5, 0.5), 0.87);
    const object = new Points(geometry, this.material);
    object.position.copy(tile.box.min);
    object.scale.setScalar(tile.edge);
    object.frustumCulled = false;  // the tree has done that
    object.onBeforeRender = () => {
      this.material.uniforms.cell.value = tile.cell;
      this.material.uniformsNeedUpdate = true;
    };
    const heights = tile.level === this.tree.top ? shorts.array.filter((_, i) => i % 8 === 2).sort() : [];
    const at = (share) => (heights[Math.floor(share * (heights.length - 1))] ?? 0) / 65535;  // but for a few that lie apart
    return { geometry, object, count, buffer, low: at(0.01), high: at(0.99) };
  }

  blocksChanged(blocks) {
    this.tree?.update(blocks);
    this.touch();
  }

  colourBy(mode) {
    const texture = new DataTexture(scaleOf(mode), 256, 1);
    texture.needsUpdate = true;
    this.material.uniforms.scale.value?.dispose();
    this.material.uniforms.scale.value = texture;
    this.material.uniforms.mode.value = kModes[mode];
    this.touch();
  }
  set lastVersion(number) { this.material.uniforms.lastVersion.value = Math.max(number, 1); this.touch(); }
  set showsChanges(shows) { this.material.uniforms.showsChanges.value = shows; this.touch(); }
  get showsChanges() { return this.material.uniforms.showsChanges.value; }
  /** [m] in the map; nothing above is drawn. */
  set top(height) { this.material.uniforms.top.value = height - (this.#frame?.center[2] ?? 0); this.touch(); }

  // ---- The robot ----

  toScene(p_map) { return new Vector3(...p_map.map((x, i) => x - this.#frame.center[i])); }
  toMap(p) { return [p.x, p.y, p.z].map((x, i) => x + this.#frame.center[i]); }

  /** `pose`: x y z qx qy qz qw in the map. */
  showRobot(pose, level) {
    const told = JSON.stringify([pose, level]);
    if (!this.#frame || told === this.#told) return;
    this.#told = told;
    this.touch();
    this.#body.material.color.set(kStateColours[level] ?? kStateColours[2]);
    if (!pose) return;
    const before = this.#robot.position.clone();
    this.#robot.position.copy(this.toScene(pose.slice(0, 3)));
    this.#robot.quaternion.copy(new Quaternion(...pose.slice(3)));
    if (this.follows && this.#robot.visible) {
      const moved = this.#robot.position.clone().sub(before);
      this.camera.position.add(moved);
      this.controls.target.add(moved);
    }
    this.#robot.visible = true;
    if (this.#placeCount === kWay) {  // the older half goes
      this.#places.copyWithin(0, 3 * (kWay / 2));
      this.#placeCount = kWay / 2;
    }
    this.#robot.position.toArray(this.#places, 3 * this.#placeCount++);
    this.#way.geometry.attributes.position.needsUpdate = true;
    this.#way.geometry.setDrawRange(0, this.#placeCount);
  }
  get robotPlaces() { return this.#placeCount; }

  /** Three doubles of where it was taken, then floats from there, in the map's axes. */
  showScan(buffer) {
    if (!this.#frame) return;
    const origin = new Float64Array(buffer, 0, 3);
    this.#scan.geometry.dispose();
    this.#scan.geometry = new BufferGeometry();
    this.#scan.geometry.setAttribute('position', new BufferAttribute(new Float32Array(buffer, 24), 3));
    this.#scan.position.copy(this.toScene([...origin]));
    this.touch();
  }

  // ---- The eye ----

  lookAtAll(fromAbove = false) {
    const box = this.tree?.box;
    if (!box || box.isEmpty()) return;
    const center = box.getCenter(new Vector3());
    const size = box.getSize(new Vector3());
    const reach = Math.max(size.x, size.y, 2 * size.z, 10);
    const distance = (0.5 * reach) / Math.tan((this.camera.fov * Math.PI) / 360) / Math.min(this.camera.aspect, 1);
    const direction = fromAbove ? new Vector3(0, -0.001, 1) : new Vector3(-0.3, -0.75, 0.6).normalize();
    this.look(center, direction.multiplyScalar(distance));
  }
  lookAtBox(min, max) {
    const center = this.toScene(min.map((x, i) => (x + max[i]) / 2));
    const reach = Math.max(...min.map((x, i) => max[i] - x), 3);
    const direction = this.camera.position.clone().sub(this.controls.target).normalize();
    this.look(center, direction.multiplyScalar(2.5 * reach));
  }
  look(target, offset) {
    this.controls.target.copy(target);
    this.camera.position.copy(target).add(offset);
    this.controls.update();
    this.touch();
  }

  // ---- What is under the pointer, and distances ----

  /** The drawn point nearest to the eye within a few pixels of (x, y) [CSS pixels]; null when there is none. */
  pick(x, y) {
    const kNear = 8;  // [pixels]
    const { width, height } = this.canvas.getBoundingClientRect();
    const { top, showsChanges } = this.material.uniforms;
    const view = new Matrix4().multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse);
    let best = null;
    let bestRank = Infinity;
    for (const object of this.#tiles.children) {
      const { tile } = object.userData;
      const shorts = new Uint16Array(tile.points.buffer);
      const bytes = new Uint8Array(tile.points.buffer);
      const e = new Matrix4().multiplyMatrices(view, object.matrixWorld).elements;
      for (let i = 0; i < tile.points.count; ++i) {
        const [px, py, pz] = [shorts[8 * i] / 65535, shorts[8 * i + 1] / 65535, shorts[8 * i + 2] / 65535];
        const w = e[3] * px + e[7] * py + e[11] * pz + e[15];
        if (w <= 0) continue;
        const dx = ((e[0] * px + e[4] * py + e[8] * pz + e[12]) / w + 1) * 0.5 * width - x;
        const dy = (1 - (e[1] * px + e[5] * py + e[9] * pz + e[13]) / w) * 0.5 * height - y;
        const off = Math.hypot(dx, dy);
        if (off > kNear) continue;
        const change = bytes[16 * i + 14];
        const z = tile.box.min.z + pz * tile.edge;
        if (z > top.value || (change === 2 && !showsChanges.value)) continue;
        const rank = w * (1 + off / kNear / 20);
        if (rank >= bestRank) continue;
        bestRank = rank;
        const at = new Vector3(px, py, pz).multiplyScalar(tile.edge).add(tile.box.min);
        best = {
          at, cell: tile.cell, change,
          since: shorts[8 * i + 3], seen: shorts[8 * i + 4], probability: bytes[16 * i + 13] / 255,
        };
      }
    }
    return best;
  }

  /** A dot at each place, and a line through them. */
  mark(places) {
    this.#marks.clear();
    for (const at of places) {
      const dot = new Mesh(new SphereGeometry(1, 12, 8), new MeshBasicMaterial({ color: 0xffffff, depthTest: false, transparent: true }));
      dot.renderOrder = 1;
      dot.position.copy(at);
      dot.scale.setScalar(0.006 * at.distanceTo(this.camera.position));
      this.#marks.add(dot);
    }
    if (places.length > 1) {
      const line = new Line(new BufferGeometry().setFromPoints(places), new LineBasicMaterial({ color: 0xffffff, depthTest: false, transparent: true }));
      line.renderOrder = 1;
      this.#marks.add(line);
    }
    this.touch();
  }

  // ---- A frame ----

  #resize() {
    const { width, height } = this.canvas.getBoundingClientRect();
    const ratio = Math.min(devicePixelRatio, 2) * (this.#isStill ? 1 : this.#resolution);
    if (this.canvas.width === Math.floor(width * ratio) && this.canvas.height === Math.floor(height * ratio)) return;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    this.touch();
  }

  /**
   * Fewer points when frames take too long, and then fewer pixels; the other way round when there is time. Detail degrades,
   * frames do not.
   */
  #adapt(elapsed) {
    const kLong = 28;  // [ms], less than 36 frames a second
    const kShort = 19;
    const kFewest = 20_000;
    const kCoarsest = 0.35;
    this.#timed.push(elapsed);
    const count = this.#timed.length;
    const mean = this.#timed.reduce((sum, time) => sum + time, 0) / count;
    if (count < 3 || (count < 8 && mean < 2 * kLong)) return;
    this.frameTime = mean;
    this.#timed = [];
    const slowness = Math.max(0.2, kLong / this.frameTime);
    if (this.frameTime > kLong) {
      if (this.budget > kFewest) this.budget = Math.max(kFewest, Math.min(this.budget, 1.2 * this.drawnPoints) * slowness);
      else this.#resolution = Math.max(kCoarsest, this.#resolution * Math.sqrt(slowness));
    } else if (this.frameTime < kShort) {
      if (this.#resolution < 1) this.#resolution = Math.min(1, this.#resolution * 1.1);
      else if (this.drawnPoints > 0.7 * this.budget) this.budget = Math.min(kMostPoints, this.budget * 1.15);
    }
  }

  #draw(now) {
    requestAnimationFrame((next) => this.#draw(next));
    this.#resize();
    if (!this.tree) return;
    const kRest = 400;       // [ms] after which nothing seems to move
    const kStillTime = 300;  // [ms] that a frame may take then
    const elapsed = now - this.#last;
    if (!this.#isDirty && this.tree.isComplete) {
      this.#isMoving = false;
      if (this.#isStill || elapsed < kRest) return;
      this.#isStill = true;
      this.#stillBudget = Math.max(1, kStillTime / this.frameTime) * this.budget;
      this.#resize();
    } else if (this.#isDirty && this.#isStill && !this.#isLoading) {
      this.#isStill = false;
      this.#resize();
    }
    this.#last = now;
    const isMoving = this.#isDirty && !this.#isLoading;
    if (isMoving && this.#isMoving) this.#adapt(elapsed);
    this.#isMoving = isMoving;
    this.#isDirty = this.#isLoading = false;
    const budget = this.#isStill ? Math.min(this.#stillBudget, kMostPoints) : this.budget;
    this.camera.updateMatrixWorld();
    const view = new Matrix4().multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse);
    const focal = (0.5 * this.canvas.height) / Math.tan((this.camera.fov * Math.PI) / 360);
    this.material.uniforms.focal.value = focal;
    const drawn = this.tree.select(this.camera.position, new Frustum().setFromProjectionMatrix(view), focal, budget);
    this.#tiles.clear();
    this.drawnPoints = 0;
    for (const tile of drawn) {
      tile.points.object.userData.tile = tile;
      this.#tiles.add(tile.points.object);
      this.drawnPoints += tile.points.count;
    }
    this.#fitHeights();
    const away = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = Math.max(0.05, away / 500);
    this.camera.far = Math.max(1000, 50 * away);
    this.camera.updateProjectionMatrix();
    this.#body.scale.setScalar(Math.max(1, 0.012 * this.camera.position.distanceTo(this.#robot.position)));
    this.renderer.render(this.#scene, this.camera);
    this.onFrame();
  }

  /** The drawn picture's pixels, for who wants to look at them: RGBA, from below. */
  pixels() {
    this.renderer.render(this.#scene, this.camera);
    const gl = this.renderer.getContext();
    const bytes = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
    gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return bytes;
  }
}
