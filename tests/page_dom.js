/* A document that is enough for the script of a page: built from a tree on standard input, acted upon, told as JSON. */
"use strict";
const vm = require("vm");

class Text {
  constructor(text) { this.text = text; }
  get textContent() { return this.text; }
}

class Element {
  constructor(tag, space) {
    this.tag = tag; this.namespaceURI = space; this.attributes = {}; this.children = []; this.handlers = {};
    this.style = {}; this.hidden = false; this.parent = null; this.written = null;
  }
  setAttribute(name, value) { this.attributes[name] = String(value); }
  getAttribute(name) { return name in this.attributes ? this.attributes[name] : null; }
  get className() { return this.attributes["class"] || ""; }
  set className(name) { this.attributes["class"] = name; }
  get value() { return this.written === null ? this.attributes.value : this.written; }
  set value(value) { this.written = value; }
  get firstChild() { return this.children[0] || null; }
  get textContent() { return this.children.map((c) => c.textContent).join(""); }
  set textContent(text) { this.children = [new Text(String(text))]; }
  get clientWidth() { return this.tag === "svg" ? Element.width : 0; }
  getBoundingClientRect() { return { left: 0, top: 0, width: Element.width, height: 400 }; }
  appendChild(child) { return this.insertBefore(child, null); }
  insertBefore(child, other) {
    if (child.parent) child.parent.removeChild(child);
    const at = other === null ? this.children.length : this.children.indexOf(other);
    if (at < 0) throw new Error("insertBefore: no such child of " + this.tag);
    this.children.splice(at, 0, child);
    child.parent = this;
    return child;
  }
  removeChild(child) {
    const at = this.children.indexOf(child);
    if (at < 0) throw new Error("removeChild: no such child of " + this.tag);
    this.children.splice(at, 1);
    child.parent = null;
  }
  *all() { for (const c of this.children) if (c instanceof Element) { yield c; yield* c.all(); } }
  querySelectorAll(selector) {
    if (selector[0] !== ".") throw new Error("selector " + selector);
    return [...this.all()].filter((e) => e.className.split(" ").includes(selector.slice(1)));
  }
  querySelector(selector) { return this.querySelectorAll(selector)[0] || null; }
  addEventListener(name, act) { (this.handlers[name] = this.handlers[name] || []).push(act); }
  fire(name, event) { (this.handlers[name] || []).forEach((act) => act(Object.assign({ preventDefault() {} }, event))); }
}

function build(node, space) {
  if (typeof node === "string") return new Text(node);
  const own = node.tag === "svg" ? "http://www.w3.org/2000/svg" : space;
  const made = new Element(node.tag, own);
  made.attributes = node.attributes;
  node.children.forEach((child) => { const c = build(child, own); made.children.push(c); c.parent = made; });
  return made;
}

function see(root) {
  return root.querySelectorAll(".run").map((run) => {
    const svg = run.querySelector(".drawing");
    return {
      hidden: run.hidden, readout: run.querySelector(".readout").children.map((c) => c.textContent),
      spoken: run.querySelector(".readout").getAttribute("aria-live"), viewBox: svg.getAttribute("viewBox"),
      labels: svg.querySelectorAll(".label").map((e) => e.textContent), lines: svg.querySelectorAll(".line").length,
      ticks: svg.querySelectorAll(".tick").map((e) => e.textContent),
      times: svg.querySelectorAll(".tick").filter((e) => e.getAttribute("text-anchor") === "middle").map((e) => e.textContent),
      tags: [...new Set([...root.all()].map((e) => e.tag))],
      paths: svg.querySelectorAll(".line").map((e) => e.getAttribute("d")),
      focus: svg.getAttribute("tabindex"), boxes: [...run.all()].filter((e) => e.tag === "input").length,
    };
  });
}

function act(root, step) {
  const runs = root.querySelectorAll(".run"), run = runs.find((r) => !r.hidden), svg = run.querySelector(".drawing");
  if (step.key) svg.fire("keydown", { key: step.key, shiftKey: Boolean(step.shift) });
  if (step.move !== undefined) svg.fire("pointermove", { clientX: step.move });
  if (step.drag) { svg.fire("pointerdown", { clientX: step.drag[0] }); svg.fire("pointerup", { clientX: step.drag[1] }); }
  if (step.click) [...run.all()].find((e) => e.tag === "button" && e.textContent === step.click).fire("click");
  if (step.toggle) {
    const item = run.querySelectorAll(".key").find((e) => e.getAttribute("data-key") === step.toggle);
    const box = [...item.all()].find((e) => e.tag === "input");
    box.checked = !box.checked;
    box.fire("change");
  }
  if (step.choose !== undefined) {
    const choice = [...root.all()].find((e) => e.tag === "select");
    choice.value = String(step.choose);
    choice.fire("change");
  }
}

let text = "";
process.stdin.on("data", (part) => { text += part; });
process.stdin.on("end", () => {
  const given = JSON.parse(text), root = build(given.tree, "http://www.w3.org/1999/xhtml");
  Element.width = given.width;
  const document = {
    createElement: (tag) => new Element(tag, "http://www.w3.org/1999/xhtml"),
    createElementNS: (space, tag) => new Element(tag, space),
    querySelectorAll: (selector) => root.querySelectorAll(selector),
  };
  vm.runInNewContext(given.script, { document, window: { addEventListener() {} } });
  const seen = [see(root)];
  given.steps.forEach((step) => { act(root, step); seen.push(see(root)); });
  process.stdout.write(JSON.stringify(seen));
});
