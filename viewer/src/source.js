// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// Where maps come from. Bytes are laid out as src/evermap/web/detail/map_tiles.hpp says.

/** A block that holds leaves. */
function blocksOf(buffer) {
  const view = new DataView(buffer);
  const blocks = [];
  for (let i = 0; i + 20 <= buffer.byteLength; i += 20) {
    blocks.push({
      at: [view.getInt32(i, true), view.getInt32(i + 4, true), view.getInt32(i + 8, true)],
      leaves: view.getUint32(i + 12, true),
      revision: view.getUint32(i + 16, true),
    });
  }
  return blocks;
}

/** A robot or a program that serves files. */
export class ServerSource {
  finestLevel = 0;
  hasOneLevel = false;

  async #fetch(path, options) {
    const response = await fetch(path, { credentials: 'same-origin', ...options });
    if (!response.ok) throw new Error((await response.text()).trim() || response.statusText);
    return response;
  }

  async page() { return (await this.#fetch('/api/page')).json(); }
  async status() { return (await this.#fetch('/api/status')).json(); }
  async blocks(map) { return blocksOf(await (await this.#fetch(`/api/maps/${map}/blocks`)).arrayBuffer()); }
  async tile(map, level, at) {
    return (await this.#fetch(`/api/maps/${map}/tiles/${level}/${at.join('/')}`)).arrayBuffer();
  }
  async changes(map) { return (await this.#fetch(`/api/maps/${map}/changes`)).json(); }
  async command(command) {
    const response = await this.#fetch('/api/command', { method: 'POST', body: JSON.stringify({ command }) });
    return (await response.json()).reply;
  }

  /** Hears what the server says by itself, for ever; `hear.again` is called whenever a connection is made. */
  listen(hear) {
    const kRetry = 1000; // [ms]
    const url = new URL('/api/live', location.href);
    url.protocol = location.protocol === 'https:' ? 'wss:' : 'ws:';
    const socket = new WebSocket(url);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => hear.again();
    socket.onmessage = ({ data }) => {
      if (typeof data !== 'string') return hear.scan(data);
      const message = JSON.parse(data);
      if (message.blocks) {
        hear.blocks(message.blocks.map(([x, y, z, leaves, revision]) => ({ at: [x, y, z], leaves, revision })));
      }
      if (message.status) hear.status(message.status);
    };
    socket.onclose = () => {
      hear.silence();
      setTimeout(() => this.listen(hear), kRetry);
    };
  }
}

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes.buffer;
}

/** A map that the page itself holds, in tiles of one level. */
export class EmbeddedSource {
  #data;
  #tiles = new Map();

  constructor(text) {
    this.#data = JSON.parse(text);
    this.finestLevel = this.#data.level;
    for (const { at, points } of this.#data.tiles) this.#tiles.set(at.join('/'), points);
  }

  hasOneLevel = true;

  async page() { return this.#data; }
  async blocks() { return blocksOf(bytesOf(this.#data.blocks)); }
  async tile(_map, _level, at) { return bytesOf(this.#tiles.get(at.join('/')) ?? ''); }
  async changes() { return this.#data.changes ?? []; }
}

export function openSource() {
  const embedded = document.getElementById('map-data');
  return embedded ? new EmbeddedSource(embedded.textContent) : new ServerSource();
}
