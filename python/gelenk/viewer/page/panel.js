// SPDX-License-Identifier: BSD-3-Clause
// The panel beside the canvas: the charts and the list to choose their signals from.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  const mostCharts = 6;
  const longestList = 200;

  Gelenk.Panel = class {
    constructor(recording, player, redraw) {
      Object.assign(this, { recording, player, redraw });
      this.element = document.getElementById("panel");
      this.charts = [];
      this.available = (recording.frames > 1 || recording.live) && recording.signals.length > 0;
      if (!this.available) return;
      this.search = document.getElementById("search");
      this.search.addEventListener("input", () => this.fillList());
      for (const name of recording.shown) {
        const signal = recording.signals.find((candidate) => candidate.name === name);
        if (signal) this.add(signal);
      }
      this.fillList();
      new ResizeObserver(() => this.prepare()).observe(document.getElementById("charts"));
      document.getElementById("chooser").open = this.charts.length === 0;
      // In a small frame the mechanism needs all the room until plots are asked for.
      this.setVisible(window.innerHeight >= 440 && (window.innerWidth > 520 || window.innerHeight >= 600));
    }

    get visible() {
      return this.available && !this.element.hidden;
    }

    setVisible(visible) {
      this.element.hidden = !(visible && this.available);
      this.redraw();
    }

    setColors(colors) {
      this.colors = colors;
      this.prepare();
    }

    prepare() {
      if (!this.visible || !this.colors) return;
      for (const chart of this.charts) chart.prepare(this.colors);
      this.redraw();
    }

    draw() {
      if (!this.visible) return;
      for (const chart of this.charts) chart.draw(this.player);
    }

    add(signal) {
      if (this.charts.length >= mostCharts || this.chartOf(signal)) return;
      const chart = new Gelenk.Chart(this.recording.time, signal, (t) => this.player.showTime(t));
      this.charts.push(chart);
      document.getElementById("charts").append(chart.canvas);
    }

    remove(signal) {
      const chart = this.chartOf(signal);
      if (!chart) return;
      chart.canvas.remove();
      this.charts.splice(this.charts.indexOf(chart), 1);
    }

    // Call when frames have been added.
    extend() {
      for (const chart of this.charts) chart.measure(this.recording.time);
      this.prepare();
    }

    chartOf(signal) {
      return this.charts.find((chart) => chart.signal === signal);
    }

    fillList() {
      const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
      const found = this.recording.signals.filter((signal) => {
        const name = signal.name.toLowerCase();
        return words.every((word) => name.includes(word));
      });
      const list = document.getElementById("signals");
      list.replaceChildren(...found.slice(0, longestList).map((signal) => this.listItem(signal)));
      document.getElementById("more").textContent = found.length > longestList
        ? `${found.length - longestList} more; type more of the name.`
        : found.length ? "" : "No signal has this name.";
      this.updateChosen();
    }

    listItem(signal) {
      const item = document.createElement("li");
      const label = document.createElement("label");
      const box = document.createElement("input");
      const unit = document.createElement("span");
      box.type = "checkbox";
      box.checked = Boolean(this.chartOf(signal));
      box.addEventListener("change", () => {
        if (box.checked) this.add(signal);
        else this.remove(signal);
        this.updateChosen();
        this.prepare();
      });
      unit.className = "unit";
      unit.textContent = signal.unit ? `[${signal.unit}]` : "";
      label.append(box, signal.name, unit);
      item.append(label);
      return item;
    }

    updateChosen() {
      const full = this.charts.length >= mostCharts;
      document.getElementById("chosen").textContent =
        `(${this.charts.length} of ${this.recording.signals.length}${full ? ", no more than " + mostCharts + " at once" : ""})`;
      for (const box of document.querySelectorAll("#signals input")) box.disabled = full && !box.checked;
    }
  };
})();
