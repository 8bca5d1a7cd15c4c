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
const MODES = ["reference_closed", "engine_closed", "engine_replay"];
const ENGINES = MODES.slice(1);
const [LEFT, RIGHT] = [40, 12]; // [px] beside the curves
const FIELDS = 7; // pusher x, y; tee x, y, yaw; action x, y
// On the dark table the colors are those of rviz, in every theme.
const dark = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--dark-${name}`).trim();
const ON_TABLE = {
  table: dark("table"), walls: dark("walls"), pusher: dark("ink"), target: dark("ink"), arrow: dark("arrow"), dim: dark("dim"),
  reference_closed: dark("reference"), engine_closed: dark("engine"), engine_replay: dark("replay"),
};
const geometry = JSON.parse(document.getElementById("geometry").textContent);
const seconds = (steps) => `${(steps * geometry.controlStep).toFixed(1)} s`;
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

// Meters to pixels of a square canvas that shows the table up to `half` meters from its origin.
class TableView {
  constructor(canvas, half = geometry.wall + 0.02) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.half = half;
  }
  x(meters) { return ((meters + this.half) / (2 * this.half)) * this.canvas.width; }
  y(meters) { return ((this.half - meters) / (2 * this.half)) * this.canvas.height; }
  length(meters) { return (meters / (2 * this.half)) * this.canvas.width; }

  clear() {
    const inner = geometry.wall;
    const [middle_x, middle_y] = geometry.wallMiddle;
    const [x, y, yaw] = geometry.target;
    this.context.globalAlpha = 1;
    this.context.fillStyle = ON_TABLE.walls;
    this.context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    this.context.fillStyle = ON_TABLE.table;
    this.context.fillRect(
      this.x(middle_x - inner), this.y(middle_y + inner), this.length(2 * inner), this.length(2 * inner),
    );
    this.tee({ tee: [x, y], yaw }, { stroke: ON_TABLE.target, width: 0.004, opacity: 0.7 });
  }

  // A bar of 0.1 m at the lower left.
  scale() {
    const draw = this.context;
    const [x, y, length] = [this.x(0.03 - geometry.wall), this.y(0.03 - geometry.wall), this.length(0.1)];
    draw.fillStyle = ON_TABLE.dim;
    draw.fillRect(x, y, length, 3);
    draw.font = `${this.canvas.width / 28}px sans-serif`;
    draw.textAlign = "left";
    draw.fillText("0.1 m", x, y - 7);
  }

  tee(state, { fill = null, stroke = null, width = 0.003, opacity = 1 }) {
    const { barHalfLength: a, barHalfWidth: w, stemHalfWidth: v, stemOffset, stemHalfLength } = geometry;
    const end = -stemOffset - stemHalfLength;
    const outline = [[-a, w], [a, w], [a, -w], [v, -w], [v, end], [-v, end], [-v, -w], [-a, -w]];
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
    this.scale();
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
    this.views = {};
    this.badges = {};
    for (const mode of MODES) {
      const figure = find(`.script figure[data-mode=${mode}]`);
      this.views[mode] = new TableView(figure.querySelector("canvas"));
      this.badges[mode] = figure.querySelector(".badge");
    }
    this.curve = find("canvas.curve");
    this.select = find(".episode");
    this.scrub = find(".scrub");
    this.marks = find(".marks");
    this.clock = find(".clock");
    this.play = find(".play");
    this.mode = find(".mode");
    this.speed = find(".speed");
    this.ghost = find(".ghost");
    this.time = 0; // [control steps]
    this.pointed = null; // [control steps] where the pointer is on the curves
    this.playing = false;
    this.order = data.episodes.map((one) => one.episode); // for previous and next; filters change it
    this.onSeek = () => {};
    for (const { episode, kind } of data.episodes) {
      this.select.append(element("option", { value: episode, textContent: `${episode} (${KIND_NAMES[kind]})` }));
    }
    for (const episode of data.first) {
      const { kind } = data.episodes.find((one) => one.episode === episode);
      const button = element("button", { type: "button", textContent: `${KIND_NAMES[kind]}: episode ${episode}` });
      button.addEventListener("click", () => this.show(episode));
      find(".kinds").append(button);
    }
    this.select.addEventListener("change", () => this.show(Number(this.select.value)));
    find(".previous").addEventListener("click", () => this.turn(-1));
    find(".next").addEventListener("click", () => this.turn(1));
    this.scrub.addEventListener("input", () => { this.pause(); this.seek(Number(this.scrub.value)); });
    this.play.addEventListener("click", () => (this.playing ? this.pause() : this.start()));
    this.mode.addEventListener("change", () => { section.dataset.shown = this.mode.value; });
    this.ghost.addEventListener("change", () => this.draw());
    const place = (event) => {
      const { left, width } = this.curve.getBoundingClientRect();
      const share = (event.clientX - left - LEFT) / (width - LEFT - RIGHT);
      return Math.round(Math.min(Math.max(share, 0), 1) * this.last);
    };
    this.curve.addEventListener("pointermove", (event) => { this.pointed = place(event); this.drawCurves(); });
    this.curve.addEventListener("pointerleave", () => { this.pointed = null; this.drawCurves(); });
    this.curve.addEventListener("click", (event) => { this.pause(); this.seek(place(event)); });
    window.addEventListener("resize", () => this.drawCurves());
    this.show(data.first[0] ?? data.episodes[0].episode);
  }

  has(episode) { return this.data.episodes.some((one) => one.episode === episode); }

  show(episode, time = 0) {
    this.pause();
    this.select.value = episode;
    const { states, succeeds, stuck, first_divergence: left } = this.data.episodes.find((one) => one.episode === episode);
    this.states = Object.fromEntries(MODES.map((mode) => [mode, unpack(states[mode])]));
    this.succeeds = succeeds;
    this.stuck = stuck;
    this.last = Math.max(...MODES.map((mode) => this.states[mode].count)) - 1;
    this.scrub.max = this.last;
    const reference = this.states.reference_closed;
    this.apart = Object.fromEntries(ENGINES.map((mode) => {
      const common = Math.min(reference.count, this.states[mode].count);
      return [mode, Array.from({ length: common }, (_, step) => divergence(reference.at(step), this.states[mode].at(step)))];
    }));
    this.marks.replaceChildren(...ENGINES.filter((mode) => left[mode] !== null).map((mode) => {
      const mark = element("i", { className: mode });
      mark.style.left = `${(100 * left[mode]) / Math.max(1, this.last)}%`;
      return mark;
    }));
    this.seek(Math.min(Math.max(time, 0), this.last));
    this.onSeek();
  }

  turn(way) {
    const at = this.order.indexOf(Number(this.select.value));
    const next = this.order[at < 0 ? 0 : at + way];
    if (next !== undefined) { this.show(next); }
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
    const was = this.playing;
    this.playing = false;
    this.play.textContent = "Play";
    if (was) { this.onSeek(); }
  }

  step(steps) {
    this.pause();
    this.seek(Math.min(Math.max(Math.round(this.time) + steps, 0), this.last));
    this.onSeek();
  }

  seek(time) {
    this.time = time;
    this.scrub.value = Math.floor(time);
    this.clock.textContent = seconds(time);
    this.draw();
  }

  draw() {
    const reference = this.states.reference_closed;
    const running = this.time <= reference.count - 1;
    for (const mode of MODES) {
      const states = this.states[mode];
      const ghost = mode !== "reference_closed" && running && this.ghost.checked ? between(reference, this.time) : null;
      this.views[mode].world(states, this.time, mode, ghost);
      this.badge(mode, states);
    }
    this.drawCurves();
  }

  // What has become of a world: nothing while it runs, then since when it is stuck, or how and when it ended. Changes
  // rarely.
  badge(mode, states) {
    const ended = this.time >= states.count - 1;
    const stuck = this.stuck[mode] !== null && this.time >= this.stuck[mode];
    const [end, good] = [seconds(states.count - 1), this.succeeds[mode]];
    const text = stuck ? `stuck since ${seconds(this.stuck[mode])}`
      : !ended ? "" : good ? `success at ${end}` : `no success, ended at ${end}`;
    const badge = this.badges[mode];
    if (badge.textContent !== text) {
      badge.textContent = text;
      badge.className = ended || stuck ? `badge ${good ? "good" : "bad"}` : "badge";
    }
  }

  // Position above, angle below, each with the bound; the line marks the time, or where the pointer is.
  drawCurves() {
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
    const foot = 16; // [px] for the times
    const x = (step) => LEFT + (step / Math.max(1, this.last)) * (width - LEFT - RIGHT);
    const line = (points, color, thick, dashes = []) => {
      draw.setLineDash(dashes);
      draw.strokeStyle = color;
      draw.lineWidth = thick;
      draw.beginPath();
      points.forEach((point) => draw.lineTo(...point));
      draw.stroke();
      draw.setLineDash([]);
    };
    const text = (words, at, y, align, color = ON_TABLE.dim) => {
      draw.textAlign = align;
      draw.fillStyle = color;
      draw.fillText(words, at, y);
    };
    draw.font = "12px sans-serif";
    const cursor = this.pointed ?? this.time;
    const half = (height - foot) / 2;
    names.forEach((name, i) => {
      const [top, bottom] = [i * half + 16, (i + 1) * half - 4];
      const most = Math.max(1.2 * bounds[i], ...ENGINES.flatMap((mode) => this.apart[mode].map((pair) => pair[i])));
      const y = (value) => bottom - (value / most) * (bottom - top);
      line([[x(0), y(0)], [x(this.last), y(0)]], ON_TABLE.walls, 1);
      line([[x(0), y(bounds[i])], [x(this.last), y(bounds[i])]], ON_TABLE.dim, 1, [5, 5]);
      text(most.toFixed(2), LEFT - 4, top + 4, "right");
      text("0", LEFT - 4, bottom + 3, "right");
      text(name, LEFT, top - 5, "left", ON_TABLE.target);
      for (const mode of ENGINES) {
        line(this.apart[mode].map((pair, step) => [x(step), y(pair[i])]), ON_TABLE[mode], 2);
      }
      let right = width - RIGHT;
      for (const mode of [...ENGINES].reverse()) {
        const pair = this.apart[mode][Math.floor(cursor)];
        const value = pair ? pair[i].toFixed(3) : "ended";
        text(value, right, top - 5, "right", ON_TABLE[mode]);
        right -= draw.measureText(value).width + 12;
      }
      if (i === 0) { text(seconds(cursor), right, top - 5, "right", ON_TABLE.target); }
    });
    const every = [1, 2, 5, 10, 20, 50, 100].find((s) => this.last * geometry.controlStep / s <= 8) ?? 200; // [s]
    for (let s = 0; s <= this.last * geometry.controlStep; s += every) {
      text(`${s} s`, Math.min(x(s / geometry.controlStep), width - 14), height - 4, "center");
    }
    line([[x(cursor), 0], [x(cursor), height - foot]], ON_TABLE.target, 1);
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

// Shows an episode, and the player whole where the screen is high enough for it.
function visit(player, episode, time = 0) {
  player.show(episode, time);
  const { section } = player;
  section.scrollIntoView({ block: section.offsetHeight <= window.innerHeight ? "center" : "end" });
}

// A small table for each episode: the tee's paths from its start, and where it ends.
function drawPaths(box, data, player) {
  const keys = box.parentElement.querySelector(".keys");
  for (const kind of KINDS) {
    const count = data.episodes.filter((one) => one.kind === kind).length;
    keys.append(element("span", { className: kind, textContent: `${KIND_NAMES[kind]} ${count}` }));
  }
  for (const { episode, kind, states, stuck } of data.episodes) {
    const since = [["reference", "reference_closed"], ["engine", "engine_closed"]].filter(([, mode]) => stuck[mode] !== null)
      .map(([role, mode]) => `; ${role} stuck since ${seconds(stuck[mode])}`).join("");
    const button = element("button", { type: "button", className: kind, title: `episode ${episode}: ${KIND_NAMES[kind]}${since}` });
    button.setAttribute("aria-label", button.title);
    const canvas = element("canvas", { width: 208, height: 208 });
    button.append(canvas, element("span", { textContent: episode }));
    button.addEventListener("click", () => visit(player, episode));
    button.dataset.episode = episode;
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
  ["reference steps", (v) => v], ["engine steps", (v) => v], ["reference ends", (v) => v], ["engine ends", (v) => v],
  ["position divergence [m]", (v) => (v === null ? "" : v.toFixed(4))],
  ["angle divergence [rad]", (v) => (v === null ? "" : v.toFixed(4))],
  ["leaves the bound at step", (v) => (v === null ? "" : v)], ["cause", (v) => v],
];
const ROWS_PER_PAGE = 100;

class EpisodeTable {
  constructor(table, rows, player) {
    this.all = rows;
    this.rows = rows;
    this.player = player;
    this.run = table.dataset.run;
    this.page = 0;
    this.column = 0;
    this.ascending = true;
    const card = table.closest("section");
    this.pages = card.querySelector(".pages");
    this.count = card.querySelector(".count");
    this.filters = Object.fromEntries(["kind", "cause", "least"].map((name) => [name, card.querySelector(`.filters .${name}`)]));
    for (const kind of KINDS) {
      this.filters.kind.append(element("option", { value: KINDS.indexOf(kind), textContent: KIND_NAMES[kind] }));
    }
    for (const cause of [...new Set(rows.map((row) => row[10]))].filter(Boolean).sort()) {
      this.filters.cause.append(element("option", { value: cause, textContent: cause }));
    }
    for (const filter of Object.values(this.filters)) { filter.addEventListener("input", () => this.filter()); }
    card.querySelector(".csv").addEventListener("click", () => this.download());
    const head = element("tr");
    this.heads = COLUMNS.map(([name], column) => {
      const cell = element("th", { scope: "col" });
      const button = element("button", { type: "button", textContent: name });
      button.addEventListener("click", () => this.sort(column));
      cell.append(button);
      head.append(cell);
      return cell;
    });
    table.tHead.replaceChildren(head);
    this.body = table.tBodies[0];
    this.filter();
  }

  // Rows that pass all filters; the small pictures, and previous and next of the player, follow.
  filter() {
    const { kind, cause, least } = this.filters;
    this.rows = this.all.filter((row) =>
      (kind.value === "" || row[2] === Number(kind.value)) &&
      (cause.value === "" || row[10] === cause.value) &&
      (least.value === "" || (row[7] !== null && row[7] >= Number(least.value))));
    const shown = new Set(this.rows.map((row) => row[0]));
    if (this.player) {
      this.player.order = this.player.data.episodes.map((one) => one.episode).filter((episode) => shown.has(episode));
      for (const button of document.querySelectorAll(`#${this.run} .paths button`)) {
        button.hidden = !shown.has(Number(button.dataset.episode));
      }
    }
    this.count.textContent = this.rows.length < this.all.length ? `${this.rows.length} of ${this.all.length}` : "";
    this.sorted();
  }

  sort(column) {
    this.ascending = column === this.column ? !this.ascending : true;
    this.column = column;
    this.sorted();
  }

  sorted() {
    const column = this.column;
    const sign = this.ascending ? 1 : -1;
    const numeric = (row) => (typeof row[column] === "string" && row[column] !== "" && !isNaN(row[column]) ? Number(row[column]) : row[column]);
    const missing = (value) => value === null || value === "";
    this.rows.sort((a, b) => {
      const [x, y] = [numeric(a), numeric(b)];
      if (missing(x) || missing(y)) { return missing(x) - missing(y) || a[0] - b[0]; } // last, either way
      return sign * (x < y ? -1 : x > y ? 1 : 0) || a[0] - b[0];
    });
    this.page = 0;
    this.draw();
  }

  csv() {
    const quoted = (value) => (/[",\n]/.test(value) ? `"${value.replaceAll('"', '""')}"` : value);
    const lines = this.rows.map((row) => row.map((value, column) => quoted(String(COLUMNS[column][1](value)))));
    return [COLUMNS.map(([name]) => name), ...lines].map((cells) => `${cells.join(",")}\n`).join("");
  }

  download() {
    const address = URL.createObjectURL(new Blob([this.csv()], { type: "text/csv" }));
    element("a", { href: address, download: `${this.run}-episodes.csv` }).click();
    setTimeout(() => URL.revokeObjectURL(address), 0);
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
        if ((column === 0 || column === 9) && value !== null && this.player && this.player.has(row[0])) {
          const time = column === 0 ? 0 : value;
          const link = element("a", { href: addressOf(this.run, row[0], time), textContent: text });
          link.addEventListener("click", (event) => { event.preventDefault(); visit(this.player, row[0], time); });
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

// "#run=run1&episode=7&t=2.3": an episode of a run, at a time [s]. The first run needs no name.
function addressOf(run, episode, time) {
  const name = run === "run0" ? "" : `run=${run}&`;
  return `#${name}episode=${episode}&t=${(time * geometry.controlStep).toFixed(1)}`;
}

function follow(address) {
  const words = new URLSearchParams(address.slice(1));
  const player = window.players[words.get("run") ?? "run0"];
  const episode = Number(words.get("episode") ?? NaN);
  const time = Number(words.get("t") ?? 0) / geometry.controlStep;
  if (player && player.has(episode)) { visit(player, episode, Number.isFinite(time) ? Math.round(time) : 0); }
}

document.documentElement.classList.add("scripted");
window.players = {};
window.tables = {};
for (const article of document.querySelectorAll("article.run")) {
  const { player: data, table } = JSON.parse(document.getElementById(`${article.id}-data`).textContent);
  let player = null;
  if (data) {
    player = window.players[article.id] = new Player(article.querySelector(".player"), data);
    drawPaths(article.querySelector(".paths"), data, player);
  }
  window.tables[article.id] = new EpisodeTable(article.querySelector("table.episodes"), table, player);
}
let active = Object.values(window.players)[0]; // the player that keys move: the one used last
follow(location.hash);
window.addEventListener("hashchange", () => follow(location.hash));
for (const [run, player] of Object.entries(window.players)) {
  player.onSeek = () => {
    active = player;
    const address = addressOf(run, Number(player.select.value), Math.round(player.time));
    try { history.replaceState(null, "", address); } catch { /* a page without an address of its own */ }
  };
  player.scrub.addEventListener("change", () => player.onSeek());
  player.curve.addEventListener("click", () => player.onSeek());
}

const KEYS = {
  " ": (player) => player.play.click(),
  ArrowLeft: (player, far) => player.step(far ? -10 : -1),
  ArrowRight: (player, far) => player.step(far ? 10 : 1),
  Home: (player) => player.step(-Infinity),
  End: (player) => player.step(Infinity),
  n: (player) => player.turn(1),
  p: (player) => player.turn(-1),
};
window.addEventListener("beforeprint", () => {
  for (const details of document.querySelectorAll("details")) { details.open = true; }
});
document.addEventListener("keydown", (event) => {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const busy = event.target.closest?.("input:not([type=range]), select, textarea, a, button, summary");
  const elsewhere = busy && (key === " " || !busy.closest("button"));
  const seen = active && active.section.getBoundingClientRect();
  if (!active || !KEYS[key] || elsewhere || event.ctrlKey || event.altKey || event.metaKey) { return; }
  if (seen.bottom < 0 || seen.top > window.innerHeight) { return; }
  event.preventDefault();
  KEYS[key](active, event.shiftKey);
});
