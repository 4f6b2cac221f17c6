// SPDX-License-Identifier: BSD-3-Clause
// Sliders for inputs, start values and parameters of a run that the page computes.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  const steps = 400;  // of a slider
  const longest = 200;  // rows of a group
  const hidden = /^(solver|assembly)\.|\.fixed$/;

  // The range of a slider: around the present value, or where that is 0, what is ordinary for the unit.
  function rangeOf({ unit, min, max }, value, scales) {
    const size = value ? 2 * Math.abs(value) : scales[unit] || 1;
    if (unit === "rad") return [value - Math.PI, value + Math.PI];
    return [Math.max(min, Math.min(-size, value)), Math.min(max, Math.max(size, value))];
  }

  class Row {
    // `change` is called with the name and a value that was chosen.
    constructor(variable, value, scales, change) {
      Object.assign(this, { variable, value, change, waiting: false, next: null });
      const { name, unit, description } = variable;
      this.element = document.createElement("div");
      this.element.className = "setting";
      const label = document.createElement("label");
      const title = document.createElement("span");
      const unitText = document.createElement("span");
      title.className = "name";
      title.title = description;
      unitText.className = "unit";
      unitText.textContent = unit && unit !== "1" ? ` [${unit}]` : "";
      title.append(name, unitText);
      this.slider = document.createElement("input");
      this.number = document.createElement("input");
      this.fault = document.createElement("p");
      this.fault.setAttribute("role", "alert");
      this.fault.hidden = true;
      this.slider.type = "range";
      this.number.type = "number";
      this.number.step = "any";
      this.number.setAttribute("aria-label", `${name}, number`);
      const [low, high] = rangeOf(variable, value, scales);
      Object.assign(this.slider, { min: String(low), max: String(high), step: String((high - low) / steps || 1) });
      this.slider.addEventListener("input", () => this.choose(this.slider.valueAsNumber));
      this.number.addEventListener("change", () => this.choose(this.number.valueAsNumber));
      label.append(title, this.slider);
      this.element.append(label, this.number, this.fault);
      this.show(value);
    }

    show(value) {
      const rounded = Number(value.toPrecision(6));
      if (value < Number(this.slider.min)) this.slider.min = String(value);
      if (value > Number(this.slider.max)) this.slider.max = String(value);
      this.slider.value = String(value);
      this.number.value = String(rounded);
      this.slider.setAttribute("aria-valuetext", `${rounded} ${this.variable.unit}`);
    }

    // A value is sent when the last one has been answered, so that a long drag does not leave a queue.
    choose(value) {
      if (!Number.isFinite(value)) return;
      this.show(value);
      this.next = value;
      if (!this.waiting) this.sendNext();
    }

    sendNext() {
      if (this.next === null) return;
      this.waiting = true;
      const value = this.next;
      this.next = null;
      this.change(this.variable.name, value);
    }

    answer(text) {
      this.fault.hidden = !text;
      this.fault.textContent = text;
      this.element.classList.toggle("refused", Boolean(text));
      this.waiting = false;
      this.sendNext();
    }
  }

  Gelenk.Settings = class {
    constructor({ scales, settings }, change) {
      Object.assign(this, { scales, settings, change, rows: new Map() });
      this.element = document.getElementById("settings");
    }

    // Call once the variables are known.
    fill(variables) {
      const real = variables.filter(({ name, type, start }) => type === "real" && Number.isFinite(start) && !hidden.test(name));
      const of = (wanted) => real.filter(wanted);
      const isStart = ({ name }) => /_start(\[\d+\])?$/.test(name);
      const parameters = of(({ causality }) => causality === "parameter");
      this.addGroup("Inputs", of(({ causality }) => causality === "input"), true);
      this.addGroup("Parameters", parameters.filter((variable) => !isStart(variable)), false);
      this.addGroup("Start values", parameters.filter(isStart), false);
      this.element.hidden = !this.rows.size;
    }

    addGroup(title, variables, open) {
      if (!variables.length) return;
      const group = document.createElement("details");
      const summary = document.createElement("summary");
      summary.textContent = title;
      group.open = open;
      group.append(summary);
      for (const variable of variables.slice(0, longest)) {
        const { name, start } = variable;
        const value = Object.prototype.hasOwnProperty.call(this.settings, name) ? this.settings[name] : start;
        const row = new Row(variable, value, this.scales, this.change);
        this.rows.set(name, row);
        group.append(row.element);
      }
      this.element.append(group);
    }

    // Shows the values of a run that has been returned to; others are as in the scene.
    show(settings) {
      for (const [name, row] of this.rows) {
        row.show(Object.prototype.hasOwnProperty.call(settings, name) ? settings[name] : row.value);
      }
    }

    accept(name) {
      this.rows.get(name).answer("");
    }

    refuse(name, text) {
      this.rows.get(name).answer(text);
    }
  };
})();
