/* Charts of a page: values under the pointer, zoom, channels on and off, runs one at a time. Names reach the page as
   text only. Without this script the page shows every run, drawn. */
(function () {
  "use strict";
  var LEFT = 66, RIGHT = 12, TOP = 20, GAP = 12, FOOT = 34, LEAST = 300, PAPER = 760;
  var STEPS = { h: [0.25, 0.5, 1, 2, 3, 6, 12, 24, 48, 72, 120, 240], min: [1, 2, 5, 10, 15, 20, 30, 60] };

  /* -- numbers: no document needed ------------------------------------------------------------------------------ */
  function ticks(low, high, most, steps) {
    var rough = Math.max(high - low, 1e-12) / most, decade = Math.pow(10, Math.floor(Math.log10(rough)));
    var step = (steps || []).concat([1, 2, 5, 10].map(function (s) { return s * decade; }))
      .filter(function (s) { return s >= rough * (1 - 1e-9); })[0];
    var found = [];
    for (var i = Math.ceil(low / step - 1e-9); i <= Math.floor(high / step + 1e-9); i++) found.push(i * step);
    return found;
  }
  function write(value, digits) {
    var text = String(Number(value.toPrecision(digits)));
    return text.replace("-", "\u2212");
  }
  function after(times, x) {
    var low = 0, high = times.length;
    while (low < high) { var mid = (low + high) >> 1; if (times[mid] <= x) low = mid + 1; else high = mid; }
    return low;
  }
  function valueAt(line, x) {
    var i = after(line.t, x), t = line.t, v = line.v;
    if (!t.length || x < t[0] || x > t[t.length - 1]) return null;
    if (i >= t.length) return v[t.length - 1];
    if (v[i - 1] === null || v[i] === null) return t[i - 1] === x ? v[i - 1] : null;
    return v[i - 1] + (v[i] - v[i - 1]) * (x - t[i - 1]) / (t[i] - t[i - 1]);
  }
  function rangeOf(lines, from, to) {
    var low = Infinity, high = -Infinity;
    function see(v) { if (v !== null) { low = Math.min(low, v); high = Math.max(high, v); } }
    lines.forEach(function (line) {
      line.t.forEach(function (t, i) { if (t >= from && t <= to) see(line.v[i]); });
      see(valueAt(line, from)); see(valueAt(line, to));
    });
    if (!(high >= low)) return [0, 1];
    var room = 0.04 * (high - low) || 0.05 * Math.abs(high) || 0.5;
    return [low - room, high + room];
  }
  function zoomed(view, whole, factor, about) {
    var span = Math.min((view[1] - view[0]) * factor, whole[1] - whole[0]);
    span = Math.max(span, (whole[1] - whole[0]) * 1e-4);
    var share = (about - view[0]) / (view[1] - view[0]), from = about - share * span;
    from = Math.min(Math.max(from, whole[0]), whole[1] - span);
    return [from, from + span];
  }

  /* -- one run -------------------------------------------------------------------------------------------------- */
  function element(name, attributes, parent, text) {
    var made = document.createElementNS(parent.namespaceURI, name);
    Object.keys(attributes).forEach(function (key) { made.setAttribute(key, attributes[key]); });
    if (text !== undefined) made.textContent = text;
    parent.appendChild(made);
    return made;
  }
  function html(name, className, parent, text) {
    var made = document.createElement(name);
    if (className) made.className = className;
    if (text !== undefined) made.textContent = text;
    parent.appendChild(made);
    return made;
  }
  /* A label that has no room loses letters before its unit; whole, it is told under the pointer. */
  function shorten(label, room) {
    if (!label.getComputedTextLength || label.getComputedTextLength() <= room) return;
    var whole = label.textContent, unit = (/ \[[^\]]*\]$/.exec(whole) || [""])[0], left = whole.length - unit.length;
    do label.textContent = whole.slice(0, --left) + "\u2026" + unit; while (left > 1 && label.getComputedTextLength() > room);
    element("title", {}, label, whole);
  }
  function Run(figure) {
    this.data = JSON.parse(figure.querySelector(".chart-data").textContent);
    this.svg = figure.querySelector(".drawing");
    this.figure = figure;
    this.whole = [this.data.start, this.data.end];
    this.view = this.whole.slice();
    this.cursor = null;
    this.off = {};
    this.build();
    this.draw();
  }
  Run.prototype.build = function () {
    var run = this, bar = figureBar(this.figure);
    button(bar, "zoom in", function () { run.zoom(0.5); });
    button(bar, "zoom out", function () { run.zoom(2); });
    button(bar, "whole run", function () { run.view = run.whole.slice(); run.draw(); });
    html("span", "hint", bar, "drag over the chart to zoom; on it: arrows, + and \u2212, 0 for the whole run");
    this.readout = html("p", "readout", this.figure);
    this.readout.setAttribute("role", "status");
    this.figure.insertBefore(this.readout, this.svg);
    Array.prototype.forEach.call(this.figure.querySelectorAll(".key"), function (item) { run.addSwitch(item); });
    this.svg.setAttribute("tabindex", "0");
    this.svg.setAttribute("role", "application");
    this.svg.addEventListener("keydown", function (event) { run.press(event); });
    this.svg.addEventListener("pointermove", function (event) { run.point(event); });
    this.svg.addEventListener("pointerdown", function (event) { run.begin = run.timeAt(event); });
    this.svg.addEventListener("pointerup", function (event) { run.release(event); });
    this.svg.addEventListener("pointerleave", function () { run.begin = null; run.show(null, false); });
    this.svg.addEventListener("dblclick", function () { run.view = run.whole.slice(); run.draw(); });
    if (window.addEventListener) {
      window.addEventListener("resize", function () { run.draw(); });
      window.addEventListener("beforeprint", function () { run.draw(PAPER); });
      window.addEventListener("afterprint", function () { run.draw(); });
    }
  };
  function figureBar(figure) {
    var bar = html("div", "bar", figure);
    figure.insertBefore(bar, figure.querySelector(".drawing"));
    return bar;
  }
  function button(parent, text, act) {
    var made = html("button", "", parent, text);
    made.setAttribute("type", "button");
    made.addEventListener("click", act);
  }
  Run.prototype.addSwitch = function (item) {
    var run = this, box = document.createElement("input"), key = item.getAttribute("data-key");
    var label = document.createElement("label");
    while (item.firstChild) label.appendChild(item.firstChild);
    box.setAttribute("type", "checkbox");
    box.checked = true;
    box.addEventListener("change", function () { run.off[key] = !box.checked; run.draw(); });
    label.insertBefore(box, label.firstChild);
    item.appendChild(label);
  };
  Run.prototype.lines = function (plot) {
    var off = this.off;
    return plot.lines.filter(function (line) { return !off[line.key]; });
  };
  Run.prototype.draw = function (asked) {
    var run = this, wide = asked || this.svg.clientWidth || 960, top = 0;
    this.width = Math.max(wide, LEAST);
    while (this.svg.firstChild) this.svg.removeChild(this.svg.firstChild);
    this.data.plots.forEach(function (plot) {
      var lines = run.lines(plot);
      if (!lines.length) return;
      run.drawPlot(plot, lines, top + TOP);
      top += TOP + plot.height + GAP;
    });
    this.bottom = top - GAP;
    this.drawClock(top);
    this.svg.setAttribute("viewBox", "0 0 " + this.width + " " + (top + FOOT));
    this.mark = element("line", { "class": "cursor", x1: -9, x2: -9, y1: 0, y2: this.bottom }, this.svg);
    if (this.cursor !== null) this.show(this.cursor, false);
  };
  Run.prototype.x = function (t) {
    return LEFT + (this.width - LEFT - RIGHT) * (t - this.view[0]) / (this.view[1] - this.view[0]);
  };
  Run.prototype.drawPlot = function (plot, lines, top) {
    var run = this, ends = rangeOf(lines, this.view[0], this.view[1]);
    function y(v) { return top + plot.height * (ends[1] - v) / (ends[1] - ends[0]); }
    shorten(element("text", { "class": "label", x: LEFT, y: top - 6 }, this.svg, plot.label), run.width - LEFT - RIGHT);
    ticks(ends[0], ends[1], 5).forEach(function (tick) {
      element("line", { "class": "grid", x1: LEFT, x2: run.width - RIGHT, y1: y(tick), y2: y(tick) }, run.svg);
      element("text", { "class": "tick", x: LEFT - 6, y: y(tick) + 4, "text-anchor": "end" }, run.svg, write(tick, 6));
    });
    lines.forEach(function (line) {
      element("path", { "class": "line", d: run.path(line, y), stroke: line.colour, "stroke-width": line.width,
        "stroke-dasharray": line.dash || "none" }, run.svg);
    });
  };
  Run.prototype.path = function (line, y) {
    var words = [], pen = "M", run = this, from = this.view[0], to = this.view[1];
    function at(t, v) {
      if (v === null) { pen = "M"; return; }
      words.push(pen + run.x(t).toFixed(1) + " " + y(v).toFixed(1));
      pen = "L";
    }
    at(from, valueAt(line, from));
    line.t.forEach(function (t, i) { if (t > from && t < to) at(t, line.v[i]); });
    at(to, valueAt(line, to));
    return words.join("");
  };
  Run.prototype.drawClock = function (top) {
    var run = this, name = this.data.clock, most = Math.max(3, Math.floor(this.width / 80));
    ticks(this.view[0], this.view[1], most, STEPS[name]).forEach(function (tick) {
      element("line", { "class": "grid", x1: run.x(tick), x2: run.x(tick), y1: TOP, y2: top - GAP }, run.svg);
      element("text", { "class": "tick", x: run.x(tick), y: top + 6, "text-anchor": "middle" }, run.svg, write(tick, 6));
    });
    var end = { "class": "tick", x: this.width - RIGHT, y: top + 24, "text-anchor": "end" };
    element("text", end, this.svg, "time [" + name + "]");
  };
  Run.prototype.show = function (t, spoken) {
    this.cursor = t;
    this.readout.setAttribute("aria-live", spoken ? "polite" : "off");
    while (this.readout.firstChild) this.readout.removeChild(this.readout.firstChild);
    if (t === null) { this.mark.setAttribute("x1", -9); this.mark.setAttribute("x2", -9); return; }
    this.mark.setAttribute("x1", this.x(t));
    this.mark.setAttribute("x2", this.x(t));
    html("b", "", this.readout, write(t, 5) + " " + this.data.clock);
    var run = this;
    this.data.plots.forEach(function (plot) {
      run.lines(plot).forEach(function (line) {
        var value = valueAt(line, t);
        if (value === null) return;
        var item = html("span", "value", run.readout, line.name + " " + write(value, 5) + " " + plot.unit);
        item.style.borderColor = line.colour;
      });
    });
  };
  Run.prototype.timeAt = function (event) {
    var box = this.svg.getBoundingClientRect();
    var x = (event.clientX - box.left) * this.width / box.width;
    var share = Math.min(Math.max((x - LEFT) / (this.width - LEFT - RIGHT), 0), 1);
    return this.view[0] + share * (this.view[1] - this.view[0]);
  };
  Run.prototype.point = function (event) { this.show(this.timeAt(event), false); };
  Run.prototype.release = function (event) {
    var end = this.timeAt(event), begin = this.begin, span = this.view[1] - this.view[0];
    this.begin = null;
    if (begin === null || begin === undefined || Math.abs(end - begin) < 0.01 * span) return;
    this.view = [Math.min(begin, end), Math.max(begin, end)];
    this.draw();
  };
  Run.prototype.zoom = function (factor) {
    var about = this.cursor === null ? (this.view[0] + this.view[1]) / 2 : this.cursor;
    this.view = zoomed(this.view, this.whole, factor, Math.min(Math.max(about, this.view[0]), this.view[1]));
    this.draw();
  };
  Run.prototype.press = function (event) {
    var span = this.view[1] - this.view[0], step = span / (event.shiftKey ? 10 : 100);
    var now = this.cursor === null ? (this.view[0] + this.view[1]) / 2 : this.cursor;
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === "ArrowLeft") now -= step;
    else if (event.key === "ArrowRight") now += step;
    else if (event.key === "Home") now = this.view[0];
    else if (event.key === "End") now = this.view[1];
    else if (event.key === "+" || event.key === "=") { this.zoom(0.5); event.preventDefault(); return; }
    else if (event.key === "-") { this.zoom(2); event.preventDefault(); return; }
    else if (event.key === "0" || event.key === "Escape") { this.view = this.whole.slice(); this.draw(); return; }
    else return;
    event.preventDefault();
    this.show(Math.min(Math.max(now, this.view[0]), this.view[1]), true);
  };

  /* -- the page ------------------------------------------------------------------------------------------------- */
  function enhance(group) {
    var figures = Array.prototype.slice.call(group.querySelectorAll(".run"));
    var runs = figures.map(function (figure) { return new Run(figure); });
    if (runs.length < 2) return;
    var label = html("label", "choose", group, "run ");
    var choice = html("select", "", label);
    figures.forEach(function (figure, i) {
      var option = html("option", "", choice, figure.getAttribute("data-name"));
      option.setAttribute("value", String(i));
    });
    function choose() {
      figures.forEach(function (figure, i) { figure.hidden = i !== Number(choice.value); });
      runs[Number(choice.value)].draw();
    }
    choice.value = "0";
    choice.addEventListener("change", choose);
    group.insertBefore(label, group.firstChild);
    choose();
  }
  if (typeof document !== "undefined") {
    Array.prototype.forEach.call(document.querySelectorAll(".charts"), enhance);
  }
  if (typeof module !== "undefined") {
    module.exports = { ticks: ticks, valueAt: valueAt, rangeOf: rangeOf, zoomed: zoomed, write: write };
  }
})();
