// SPDX-License-Identifier: BSD-3-Clause
// Plays episodes, draws paths, sorts tables. All text goes in as text, never as markup.
"use strict";

const KINDS = ["only_reference_succeeds", "both_succeed", "neither_succeeds", "only_engine_succeeds"];
const KIND_NAMES = {
  only_reference_succeeds: "reference only",
  both_succeed: "both",
  neither_succeeds: "neither",
  only_engine_succeeds: "engine only",
};
const FIELDS = 7; // pusher x, y; tee x, y, yaw; action x, y
// On the dark table the colours are those of rviz, in every theme.
const ON_TABLE = {
  table: "#2b313d", walls: "#525b6e", pusher: "#f4f4f2", target: "#f4f4f2", arrow: "#ffffff", dim: "#a3adbd",
  reference_closed: "#5aaaff", engine_closed: "#f0dc46", engine_replay: "#ee6677",
};
const geometry = JSON.parse(document.getElementById("geometry").textContent);
const element = (name, properties = {}) => Object.assign(document.createElement(name), properties);

// The states of a mode: numbers in SI units, by step.
function unpack(text) {
  const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const numbers = new Float32Array(bytes.buffer);
  return {
    count: numbers.length / FIELDS,
    at(step) {
      const n = numbers.subarray(FIELDS * step, FIELDS * (step + 1));
      return { pusher: [n[0], n[1]], tee: [n[2], n[3]], yaw: n[4], action: [n[5], n[6]] };
    },
  };
}

// Between two steps the picture moves on a straight line; the yaw takes the shorter way.
function between(states, time) {
  const last = states.count - 1;
  const step = Math.min(Math.floor(time), last);
  const a = states.at(step);
  const share = time - step;
  if (share <= 0 || step >= last) {
    return a;
  }
  const b = states.at(step + 1);
  const mix = (p, q) => p.map((value, i) => value + share * (q[i] - value));
  return { pusher: mix(a.pusher, b.pusher), tee: mix(a.tee, b.tee), yaw: a.yaw + share * wrapped(b.yaw - a.yaw), action: a.action };
}

const wrapped = (angle) => angle - 2 * Math.PI * Math.floor((angle + Math.PI) / (2 * Math.PI));

function divergence(a, b) {
  return [Math.hypot(a.tee[0] - b.tee[0], a.tee[1] - b.tee[1]), Math.abs(wrapped(a.yaw - b.yaw))];
}

// Metres to pixels of a square canvas that shows the table up to `half` metres from the target.
class TableView {
  constructor(canvas, half = geometry.wall + 0.02) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.half = half;
  }
  x(metres) { return ((metres + this.half) / (2 * this.half)) * this.canvas.width; }
  y(metres) { return ((this.half - metres) / (2 * this.half)) * this.canvas.height; }
  length(metres) { return (metres / (2 * this.half)) * this.canvas.width; }

  clear() {
    const inner = geometry.wall;
    this.context.globalAlpha = 1;
    this.context.fillStyle = ON_TABLE.walls;
    this.context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    this.context.fillStyle = ON_TABLE.table;
    this.context.fillRect(this.x(-inner), this.y(inner), this.length(2 * inner), this.length(2 * inner));
    this.tee({ tee: [0, 0], yaw: 0 }, { stroke: ON_TABLE.target, width: 0.004, opacity: 0.7 });
  }

  tee(state, { fill = null, stroke = null, width = 0.003, opacity = 1 }) {
    const { barHalfLength: a, halfWidth: w, stemHalfLength: s, stemOffset: o } = geometry;
    const outline = [[-a, w], [a, w], [a, -w], [w, -w], [w, -o - s], [-w, -o - s], [-w, -w], [-a, -w]];
    const [sin, cos] = [Math.sin(state.yaw), Math.cos(state.yaw)];
    const draw = this.context;
    draw.beginPath();
    for (const [x, y] of outline) {
      draw.lineTo(this.x(state.tee[0] + cos * x - sin * y), this.y(state.tee[1] + sin * x + cos * y));
    }
    draw.closePath();
    draw.globalAlpha = opacity;
    if (fill) { draw.fillStyle = fill; draw.fill(); }
    if (stroke) { draw.strokeStyle = stroke; draw.lineWidth = this.length(width); draw.stroke(); }
    draw.globalAlpha = 1;
  }

  path(states, until, color, width) {
    const draw = this.context;
    draw.beginPath();
    for (let step = 0; step <= until; ++step) {
      const { tee } = states.at(step);
      draw.lineTo(this.x(tee[0]), this.y(tee[1]));
    }
    draw.strokeStyle = color;
    draw.lineWidth = this.length(width);
    draw.lineJoin = "round";
    draw.stroke();
  }

  pusher(state, moves) {
    const draw = this.context;
    const [x, y] = [this.x(state.pusher[0]), this.y(state.pusher[1])];
    draw.fillStyle = ON_TABLE.pusher;
    draw.beginPath();
    draw.arc(x, y, this.length(geometry.pusherRadius), 0, 2 * Math.PI);
    draw.fill();
    const speed = Math.hypot(...state.action);
    if (!moves || speed < 0.02) { return; }
    const reach = this.length(0.1); // of 1 m/s
    const tip = [x + state.action[0] * reach, y - state.action[1] * reach];
    const angle = Math.atan2(tip[1] - y, tip[0] - x);
    draw.strokeStyle = draw.fillStyle = ON_TABLE.arrow;
    draw.lineWidth = this.length(0.005);
    draw.beginPath(); draw.moveTo(x, y); draw.lineTo(...tip); draw.stroke();
    draw.beginPath();
    for (const turn of [0, 2.5, -2.5]) {
      draw.lineTo(tip[0] + this.length(0.012) * Math.cos(angle + turn), tip[1] + this.length(0.012) * Math.sin(angle + turn));
    }
    draw.fill();
  }

  world(states, time, mode, ghost) {
    const state = between(states, time);
    this.clear();
    this.path(states, Math.min(Math.floor(time), states.count - 1), ON_TABLE[mode], 0.003);
    this.tee(state, { fill: ON_TABLE[mode] });
    if (ghost) {
      this.tee(ghost, { fill: ON_TABLE.reference_closed, opacity: 0.25 });
      this.tee(ghost, { stroke: ON_TABLE.reference_closed });
    }
    this.pusher(state, time < states.count - 1);
  }
}

class Player {
  constructor(section, data) {
    const find = (selector) => section.querySelector(selector);
    this.data = data;
    this.section = section;
    this.left = new TableView(find("canvas.left"));
    this.right = new TableView(find("canvas.right"));
    this.curve = find("canvas.curve");
    this.select = find(".episode");
    this.scrub = find(".scrub");
    this.clock = find(".clock");
    this.play = find(".play");
    this.mode = find(".mode");
    this.speed = find(".speed");
    this.ghost = find(".ghost");
    this.caption = find(".chosen");
    this.time = 0; // [control steps]
    this.playing = false;
    for (const { episode, kind } of data.episodes) {
      this.select.append(element("option", { value: episode, textContent: `${episode} (${KIND_NAMES[kind]})` }));
    }
    for (const episode of data.first) {
      const { kind } = data.episodes.find((one) => one.episode === episode);
      const button = element("button", { type: "button", textContent: `${KIND_NAMES[kind]}: ${episode}` });
      button.addEventListener("click", () => this.show(episode));
      find(".kinds").append(button);
    }
    this.select.addEventListener("change", () => this.show(Number(this.select.value)));
    this.scrub.addEventListener("input", () => { this.pause(); this.seek(Number(this.scrub.value)); });
    this.play.addEventListener("click", () => (this.playing ? this.pause() : this.start()));
    this.mode.addEventListener("change", () => this.load());
    this.ghost.addEventListener("change", () => this.draw());
    window.addEventListener("resize", () => this.drawCurve());
    this.show(data.first[0] ?? data.episodes[0].episode);
  }

  show(episode) {
    this.pause();
    this.select.value = episode;
    this.time = 0;
    this.load();
  }

  load() {
    const { states } = this.data.episodes.find((one) => one.episode === Number(this.select.value));
    this.reference = unpack(states.reference_closed);
    this.engine = unpack(states[this.mode.value]);
    this.last = Math.max(this.reference.count, this.engine.count) - 1;
    this.scrub.max = this.last;
    const replays = this.mode.value === "engine_replay";
    this.caption.textContent = `${this.data.titles.engine}, ${replays ? "open loop" : "closed loop"}`;
    this.caption.className = `chosen ${replays ? "replay" : "engine"}`;
    const common = Math.min(this.reference.count, this.engine.count);
    this.apart = Array.from({ length: common }, (_, step) => divergence(this.reference.at(step), this.engine.at(step)));
    this.seek(Math.min(this.time, this.last));
  }

  start() {
    if (this.time >= this.last) { this.time = 0; }
    this.playing = true;
    this.play.textContent = "Pause";
    let before = performance.now();
    const tick = (now) => {
      if (!this.playing) { return; }
      const steps = ((now - before) / 1000 / geometry.controlStep) * Number(this.speed.value);
      before = now;
      this.seek(Math.min(this.time + Math.max(0, steps), this.last));
      if (this.time >= this.last) { this.pause(); } else { requestAnimationFrame(tick); }
    };
    requestAnimationFrame(tick);
  }

  pause() {
    this.playing = false;
    this.play.textContent = "Play";
  }

  seek(time) {
    this.time = time;
    this.scrub.value = Math.floor(time);
    this.clock.textContent = `${(time * geometry.controlStep).toFixed(1)} s`;
    this.draw();
  }

  draw() {
    this.left.world(this.reference, this.time, "reference_closed", null);
    const ghost = this.ghost.checked ? between(this.reference, this.time) : null;
    this.right.world(this.engine, this.time, this.mode.value, ghost);
    this.drawCurve();
  }

  // Position above, angle below, each with the bound; the line marks the time.
  drawCurve() {
    const draw = this.curve.getContext("2d");
    const pixels = window.devicePixelRatio;
    const [width, height] = [this.curve.clientWidth, this.curve.clientHeight];
    this.curve.width = width * pixels; // clears it, too
    this.curve.height = height * pixels;
    draw.scale(pixels, pixels);
    draw.fillStyle = ON_TABLE.table;
    draw.fillRect(0, 0, width, height);
    const bounds = [this.data.bound.position_m, this.data.bound.angle_rad];
    const names = ["position [m]", "angle [rad]"];
    const x = (step) => 10 + (step / Math.max(1, this.last)) * (width - 20);
    draw.font = "13px sans-serif";
    names.forEach((name, i) => {
      const [top, bottom] = [i * height / 2 + 8, (i + 1) * height / 2 - 6];
      const most = Math.max(2 * bounds[i], ...this.apart.map((pair) => pair[i]));
      const y = (value) => bottom - (value / most) * (bottom - top);
      draw.strokeStyle = ON_TABLE.dim;
      draw.lineWidth = 1;
      draw.setLineDash([5, 5]);
      draw.beginPath(); draw.moveTo(x(0), y(bounds[i])); draw.lineTo(x(this.last), y(bounds[i])); draw.stroke();
      draw.setLineDash([]);
      draw.strokeStyle = ON_TABLE[this.mode.value];
      draw.lineWidth = 2;
      draw.beginPath();
      this.apart.forEach((pair, step) => draw.lineTo(x(step), y(pair[i])));
      draw.stroke();
      const now = this.apart[Math.min(Math.floor(this.time), this.apart.length - 1)][i];
      draw.fillStyle = ON_TABLE.target;
      draw.textAlign = "right";
      draw.fillText(`${name} ${now.toFixed(3)}`, width - 14, top + 10);
    });
    draw.strokeStyle = ON_TABLE.target;
    draw.lineWidth = 1;
    draw.beginPath(); draw.moveTo(x(this.time), 0); draw.lineTo(x(this.time), height); draw.stroke();
  }
}

// Half the edge of a picture that holds all of the paths [m].
function reachOf(traces) {
  let most = 0.15;
  for (const trace of traces) {
    for (let step = 0; step < trace.count; ++step) {
      most = Math.max(most, ...trace.at(step).tee.map(Math.abs));
    }
  }
  return Math.min(most + geometry.stemOffset + geometry.stemHalfLength, geometry.wall + 0.02);
}

// A small table for each episode: the tee's paths from its start, and where it ends.
function drawPaths(box, data, player) {
  const keys = box.parentElement.querySelector(".keys");
  for (const kind of KINDS) {
    const count = data.episodes.filter((one) => one.kind === kind).length;
    keys.append(element("span", { className: kind, textContent: `${KIND_NAMES[kind]} ${count}` }));
  }
  for (const { episode, kind, states } of data.episodes) {
    const button = element("button", { type: "button", className: kind, title: `episode ${episode}: ${KIND_NAMES[kind]}` });
    button.setAttribute("aria-label", button.title);
    const canvas = element("canvas", { width: 208, height: 208 });
    button.append(canvas, element("span", { textContent: episode }));
    button.addEventListener("click", () => {
      player.show(episode);
      player.section.scrollIntoView();
    });
    box.append(button);
    const traces = { reference_closed: unpack(states.reference_closed), engine_closed: unpack(states.engine_closed) };
    const view = new TableView(canvas, reachOf(Object.values(traces)));
    view.clear();
    for (const [mode, trace] of Object.entries(traces)) {
      view.path(trace, trace.count - 1, ON_TABLE[mode], 0.008);
      view.tee(trace.at(trace.count - 1), { stroke: ON_TABLE[mode], width: 0.008 });
    }
    view.tee(traces.reference_closed.at(0), { stroke: ON_TABLE.dim, width: 0.006 });
  }
}

const COLUMNS = [
  ["episode", (v) => v], ["seed", (v) => v], ["who succeeds", (v) => KIND_NAMES[KINDS[v]]],
  ["reference steps", (v) => v], ["engine steps", (v) => v],
  ["position divergence [m]", (v) => (v === null ? "" : v.toFixed(4))],
  ["angle divergence [rad]", (v) => (v === null ? "" : v.toFixed(4))],
  ["leaves the bound at step", (v) => (v === null ? "" : v)], ["cause", (v) => v],
];
const ROWS_PER_PAGE = 100;

class EpisodeTable {
  constructor(table, rows, player) {
    this.rows = rows;
    this.player = player;
    this.page = 0;
    this.column = 0;
    this.ascending = true;
    this.pages = table.closest("section").querySelector(".pages");
    const head = element("tr");
    this.heads = COLUMNS.map(([name], column) => {
      const cell = element("th", { scope: "col" });
      const button = element("button", { type: "button", textContent: name });
      button.addEventListener("click", () => this.sort(column));
      cell.append(button);
      head.append(cell);
      return cell;
    });
    const top = element("thead");
    top.append(head);
    this.body = element("tbody");
    table.append(top, this.body);
    this.draw();
  }

  sort(column) {
    this.ascending = column === this.column ? !this.ascending : true;
    this.column = column;
    const sign = this.ascending ? 1 : -1;
    const numeric = (row) => (typeof row[column] === "string" && row[column] !== "" && !isNaN(row[column]) ? Number(row[column]) : row[column]);
    const missing = (value) => value === null || value === "";
    this.rows.sort((a, b) => {
      const [x, y] = [numeric(a), numeric(b)];
      if (missing(x) || missing(y)) { return missing(x) - missing(y); } // last, either way
      return sign * (x < y ? -1 : x > y ? 1 : 0) || a[0] - b[0];
    });
    this.page = 0;
    this.draw();
  }

  draw() {
    this.heads.forEach((head, column) => {
      head.setAttribute("aria-sort", column !== this.column ? "none" : this.ascending ? "ascending" : "descending");
    });
    const first = this.page * ROWS_PER_PAGE;
    const shown = this.rows.slice(first, first + ROWS_PER_PAGE);
    this.body.replaceChildren(...shown.map((row) => {
      const line = element("tr");
      row.forEach((value, column) => {
        const cell = element("td", { className: typeof value === "number" && column !== 2 ? "number" : "" });
        const text = COLUMNS[column][1](value);
        if (column === 0 && this.player && this.player.data.episodes.some((one) => one.episode === value)) {
          const link = element("a", { href: `#${this.player.section.dataset.run}`, textContent: text });
          link.addEventListener("click", (event) => {
            event.preventDefault();
            this.player.show(value);
            this.player.section.scrollIntoView();
          });
          cell.append(link);
        } else {
          cell.textContent = text;
        }
        line.append(cell);
      });
      return line;
    }));
    const count = Math.ceil(this.rows.length / ROWS_PER_PAGE);
    this.pages.replaceChildren();
    if (count > 1) {
      const turn = (text, page) => {
        const button = element("button", { type: "button", textContent: text, disabled: page < 0 || page >= count });
        button.addEventListener("click", () => { this.page = page; this.draw(); });
        return button;
      };
      this.pages.append(turn("before", this.page - 1), ` page ${this.page + 1} of ${count} `, turn("next", this.page + 1));
    }
  }
}

window.players = {};
for (const article of document.querySelectorAll("article.run")) {
  const { player: data, table } = JSON.parse(document.getElementById(`${article.id}-data`).textContent);
  let player = null;
  if (data) {
    player = window.players[article.id] = new Player(article.querySelector(".player"), data);
    drawPaths(article.querySelector(".paths"), data, player);
  }
  new EpisodeTable(article.querySelector("table.episodes"), table, player);
}
