// SPDX-License-Identifier: BSD-3-Clause
// Sorts the table of policies by simulators, and shows the episodes of a cell. All text goes in as text.
"use strict";

const OUTCOMES = { 11: "both_succeed", 10: "only_engine_succeeds", "01": "only_reference_succeeds", "00": "neither_succeeds" };

class MatrixTable {
  constructor(table, detail, data) {
    Object.assign(this, { table, detail, data, column: null, ascending: true });
    this.body = table.tBodies[0];
    this.heads = [...table.tHead.rows[0].cells];
    this.heads.forEach((head, column) => {
      const button = element("button", { type: "button", textContent: head.textContent });
      head.replaceChildren(button);
      button.addEventListener("click", () => this.sort(column));
    });
    for (const cell of this.body.querySelectorAll("td[data-policy]")) {
      const button = element("button", { type: "button" });
      button.append(...cell.childNodes);
      cell.append(button);
      button.addEventListener("click", () => this.show(Number(cell.dataset.policy), Number(cell.dataset.simulator)));
    }
  }

  sort(column) {
    this.ascending = this.column === column ? !this.ascending : column < 2; // rates: the best first
    this.column = column;
    const value = (row) => {
      const cell = row.cells[column];
      return column < 2 ? cell.textContent : Number(cell.dataset.value ?? -1);
    };
    const order = (a, b) => (a < b ? -1 : a > b ? 1 : 0) * (this.ascending ? 1 : -1);
    this.body.append(...[...this.body.rows].sort((a, b) => order(value(a), value(b))));
    this.heads.forEach((head, i) => {
      head.setAttribute("aria-sort", i !== column ? "none" : this.ascending ? "ascending" : "descending");
    });
  }

  // The episodes of a policy in a simulator beside the same ones in its reference.
  show(number, simulator) {
    const { titles, policies, folder, first } = this.data;
    const policy = policies[number];
    const [there, here] = [policy.won[simulator], policy.won[policy.reference]];
    const kinds = [...there].map((won, episode) => OUTCOMES[`${won}${here[episode]}`]);
    const names = {
      both_succeed: "both",
      only_engine_succeeds: `${titles[simulator]} only`,
      only_reference_succeeds: `${titles[policy.reference]} only`,
      neither_succeeds: "neither",
    };
    const title = element("h3", { textContent: `${policy.name} in ${titles[simulator]}, beside ${titles[policy.reference]}` });
    const keys = element("p", { className: "keys" });
    for (const [kind, name] of Object.entries(names)) {
      const count = kinds.filter((other) => other === kind).length;
      keys.append(element("span", { className: kind, textContent: `${name}: ${count}` }));
    }
    const marks = element("div", { className: "marks-of-episodes" });
    kinds.forEach((kind, episode) => {
      marks.append(element("i", { className: kind, title: `episode ${first + episode}: ${names[kind]}` }));
    });
    const words = element("p", { className: "note", textContent: "A mark for each episode. This shows how they go:" });
    const command = element("pre", { textContent: `rosrun sim2sim_eval report ${folder}/${policy.rows[simulator]}` });
    this.detail.replaceChildren(title, keys, marks, words, command);
    this.detail.scrollIntoView({ block: "nearest" });
  }
}

const matrixData = document.getElementById("matrix-data");
if (matrixData) {
  const detail = document.querySelector(".matrix-episodes");
  window.matrix = new MatrixTable(document.querySelector("table.matrix"), detail, JSON.parse(matrixData.textContent));
}
