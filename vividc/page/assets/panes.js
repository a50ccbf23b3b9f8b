// The panes beside graph and array: regions, source, schedule, bounds, run.

const KEYWORDS = /("(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'|#.*|\b(?:def|for|in|if|elif|else|while|break|continue|return|import|from|and|or|not|range|prange|True|False|None|int|float|void|unsigned|const)\b|\b\d[\w.]*)/;

function coloured(line) {
  return line.split(KEYWORDS).map((part, index) => {
    if (index % 2 === 0) return document.createTextNode(part);
    const kind = /^["']/.test(part) ? "string" : part[0] === "#" ? "comment" : /^\d/.test(part) ? "number" : "keyword";
    return make("span", { class: kind, text: part });
  });
}

function showRegions() {
  const cards = data.regions.map((one, index) => {
    const what = one.kind === "loop" ? `II ${one.ii}` : `${one.ii} cycles`;
    const proof = one.status === "optimal" ? "optimal" : `bound ${one.lower_bound}`;
    const spent = run && run.cycles ? run.regions[index].cycles / run.cycles : null;
    const input = make("input", { type: "radio", name: "region", value: index, checked: index === state.region });
    const facts = make("span", { class: "facts" },
      make("b", { text: what }), make("span", { class: `proof ${one.status}`, text: proof }));
    const where = one.line === null ? "" : `line ${one.line}, `;
    const beside = one.drain || one.fill;
    const early = beside ? `, ${beside} cycles beside the next region` : "";
    const more = make("span", { class: "note", text: `${one.kind}, ${where}${one.operations} operations${early}` });
    const bar = spent === null ? null : make("span", { class: "share", title: `${percent(spent)} of the run's cycles` },
      make("i", { style: `width:${100 * spent}%` }));
    return make("label", { class: "card" }, input, make("span", { class: "card-name", text: one.name }), facts, more, bar);
  });
  byId("regions").replaceChildren(...cards);
}

function showSource() {
  const heats = new Map(data.lines.map((one) => [one.line, one]));
  const hottest = Math.max(1e-9, ...data.lines.map((one) => one.heat));
  const { lines, missing, file } = data.source;
  byId("source-title").textContent = file ? `Source: ${file}` : "Source";
  const spent = run && run.cycles;
  byId("source-note").textContent = missing || (spent ? "bars: share of the run's cycles" : "bars: operations in loops");
  const shown = lines.length ? lines.map((text, index) => [index + 1, text])
    : data.lines.map((one) => [one.line, ""]);
  let first = true;
  const rows = shown.map(([number, text]) => {
    const one = heats.get(number);
    const count = one ? one.operations[state.region] || 0 : 0;
    const amount = one ? (spent ? `${percent(one.heat / spent)} of the cycles, ` : "") + `${count} operations in this region` : "no operation";
    const row = make("div", { class: count ? "line here" : one ? "line hot" : "line", "data-line": one ? number : null,
      tabindex: one ? (first ? 0 : -1) : null, role: one ? "button" : null,
      "aria-label": one ? `line ${number}: ${text.trim()}; ${amount}` : null, title: one ? amount : null },
      make("span", { class: "heat" }, make("i", { style: `width:${one ? Math.max(4, (100 * one.heat) / hottest) : 0}%` })),
      make("span", { class: "number", text: number }),
      make("code", {}, ...(text ? coloured(text) : [document.createTextNode(" ")])),
      make("span", { class: "count", text: count || "" }));
    if (one) first = false;
    return row;
  });
  byId("source").replaceChildren(...rows);
}

function lineStep(element, way) {
  if (way === "Left" || way === "Right") return null;
  const all = [...element.parentElement.querySelectorAll("[data-line]")];
  return all[all.indexOf(element) + (way === "Down" ? 1 : -1)] || null;
}

function showTable() {
  const one = region();
  const placed = one.nodes.filter((node) => node.time !== null);
  byId("table-note").textContent = placed.length
    ? `one iteration: ${1 + Math.max(...placed.map((node) => node.time))} cycles to issue, ${one.stages} stage${one.stages === 1 ? "" : "s"} of ${one.ii}; the shown context is shaded`
    : "nothing is placed";
  const at = new Map();
  for (const node of placed) {
    const key = `${node.time} ${node.pe}`;
    at.set(key, [...(at.get(key) || []), node]);
  }
  const all = data.fabric.pes.map((_, index) => index);
  const busy = new Set(placed.map((node) => node.pe));
  const pes = all.length <= 16 ? all : all.filter((pe) => busy.has(pe));
  const last = Math.max(-1, ...placed.map((node) => node.time));
  const head = make("tr", {}, make("th", { scope: "col", text: "cycle" }),
    ...pes.map((pe) => make("th", { scope: "col", text: data.fabric.pes[pe].memory ? `PE ${pe} M` : `PE ${pe}` })));
  const rows = [];
  let first = true;
  for (let time = 0; time <= last; time += 1) {
    const cells = pes.map((pe) => {
      const here = at.get(`${time} ${pe}`) || [];
      const buttons = here.map((node) => {
        const button = make("span", { class: "cell", role: "button", tabindex: first ? 0 : -1, "data-node": node.id,
          "aria-label": node.title, title: node.title, text: node.name });
        button.style.background = node.colour;
        first = false;
        return button;
      });
      return make("td", {}, ...buttons);
    });
    const label = time % one.ii === 0 && one.kind === "loop" ? `${time} · s${Math.floor(time / one.ii)}` : `${time}`;
    rows.push(make("tr", { "data-context": time % one.ii, class: time % one.ii === 0 ? "stage" : null },
      make("th", { scope: "row", text: label }), ...cells));
  }
  byId("table").replaceChildren(make("table", { class: "schedule" }, make("thead", {}, head), make("tbody", {}, ...rows)));
}

function tableStep(element, way) {
  const row = element.closest("tr");
  const column = [...row.children].indexOf(element.closest("td"));
  if (way === "Left" || way === "Right") {
    const all = [...row.querySelectorAll(".cell")];
    return all[all.indexOf(element) + (way === "Right" ? 1 : -1)] || null;
  }
  let next = row;
  while ((next = way === "Down" ? next.nextElementSibling : next.previousElementSibling)) {
    const cells = [...next.querySelectorAll(".cell")];
    const beside = (cell) => Math.abs([...next.children].indexOf(cell.closest("td")) - column);
    if (cells.length) return cells.reduce((best, cell) => (beside(cell) < beside(best) ? cell : best));
  }
  return null;
}

function showTableSlot() {
  for (const row of byId("table").querySelectorAll("tr[data-context]"))
    row.classList.toggle("now", Number(row.dataset.context) === state.slot);
}

function showBounds() {
  const one = region();
  const [headline, ...more] = one.explained.split("\n");
  const rows = one.bounds.map((bound, index) => {
    const button = make("button", { type: "button", "data-bound": index, "aria-pressed": state.bound === index,
      text: bound.name, title: "Highlight it in graph, source, array and schedule" });
    return make("tr", { class: index === one.binds ? "cause" : null }, make("th", { scope: "row" }, button),
      make("td", { class: "figure", text: bound.ii }), make("td", { text: bound.reason }));
  });
  rows.push(...one.refuted.map((item) => make("tr", {}, make("th", { scope: "row", text: "refuted" }),
    make("td", { class: "figure", text: item.ii }), make("td", { text: item.by }))));
  const what = one.kind === "loop" ? "II" : "length";
  const head = make("tr", {}, ...["bound", what, "because"].map((text) => make("th", { scope: "col", text })));
  const causes = more.filter((line) => /^ {2}(what binds|fullest|minimised|II [\d .]+ neither|stopped)/.test(line));
  byId("bounds").replaceChildren(
    make("p", { class: "headline", text: headline }),
    ...causes.map((text) => make("p", { text: text.trim() })),
    make("table", { class: "bounds" }, make("thead", {}, head), make("tbody", {}, ...rows)));
}

function showRun() {
  if (!run) return;
  byId("run-pane").hidden = false;
  byId("run-note").textContent = run.cycles === null ? "" : `${run.cycles.toLocaleString("en")} cycles, ${run.switch_cycles.toLocaleString("en")} of them between regions${run.reload_cycles ? `, ${run.reload_cycles.toLocaleString("en")} to bring contexts` : ""}`;
  const parts = [];
  if (run.error || run.stopped) parts.push(make("p", { class: "error", role: "alert", text: run.error || run.stopped }));
  if (run.value) parts.push(make("p", { text: `returned value: ${run.value}` }));
  const columns = ["region", "entries", "iterations", "cycles", "share", "stalls", "FU use"];
  const rows = run.regions.map((one, index) => make("tr", {},
    make("th", { scope: "row", text: data.regions[index].name }),
    ...[one.entries, one.iterations, one.cycles].map((value) => make("td", { class: "figure", text: value.toLocaleString("en") })),
    make("td", {}, make("span", { class: "share" }, make("i", { style: `width:${(100 * one.cycles) / Math.max(1, run.cycles)}%` }))),
    make("td", { class: one.stalls ? "figure stalled" : "figure", text: one.stalls.toLocaleString("en") }),
    make("td", { class: "figure", text: percent(one.utilization) })));
  if (rows.length) parts.push(make("table", { class: "run" },
    make("thead", {}, make("tr", {}, ...columns.map((text) => make("th", { scope: "col", text })))), make("tbody", {}, ...rows)));
  byId("run").replaceChildren(...parts);
}

// Operations that issue in each cycle of the window, and stalls.
const STRIP = { width: 600, height: 34 };

function showStrip() {
  const length = run.end - run.first;
  const pes = data.fabric.pes.length;
  const bins = Math.min(length, STRIP.width);
  const issued = new Array(bins).fill(0);
  const still = new Array(bins).fill(0);
  const owner = new Array(bins).fill(0);
  const bin = (cycle) => Math.min(bins - 1, Math.floor(((cycle - run.first) * bins) / length));
  for (const [cycle, index, , ops] of run.samples) {
    issued[bin(cycle)] += ops.length / pes;
    owner[bin(cycle)] = index;
  }
  for (const cycle of run.stalled) still[bin(cycle)] += 1;
  const svg = draw("svg", { viewBox: `0 0 ${STRIP.width} ${STRIP.height}`, preserveAspectRatio: "none", "aria-hidden": "true" });
  const each = STRIP.width / bins;
  for (let index = 0; index < bins; index += 1) {
    const count = Math.max(1, length / bins);
    const high = Math.min(1, issued[index] / count) * STRIP.height;
    const x = (index * each).toFixed(2);
    const wide = Math.max(0.6, each - 0.3).toFixed(2);
    if (still[index]) svg.append(draw("rect", { class: "still", x, y: 0, width: wide, height: STRIP.height }));
    if (high) svg.append(draw("rect", { class: `owner owner-${owner[index] % 5}`, x, y: STRIP.height - high, width: wide, height: high }));
  }
  svg.append(draw("line", { id: "cursor", y1: 0, y2: STRIP.height }));
  svg.addEventListener("click", (event) => {
    const box = svg.getBoundingClientRect();
    setCycle(run.first + Math.floor(((event.clientX - box.left) / box.width) * length));
  });
  byId("strip").replaceChildren(svg);
}
