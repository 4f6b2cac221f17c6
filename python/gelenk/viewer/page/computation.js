// SPDX-License-Identifier: BSD-3-Clause
// The run that the page computes: what the buttons ask of the worker, and what the worker answers.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  const element = (id) => document.getElementById(id);
  const mostEvents = 500;  // that are listed
  const slow = 0.8;  // part of the chosen speed below which the page says that it is slower
  const degree = Math.PI / 180;

  // A thread of its own, or where the browser permits none, this one.
  function startWorker(receive) {
    const code = element("worker").textContent;
    try {
      const worker = new Worker(URL.createObjectURL(new Blob([code], { type: "text/javascript" })));
      worker.addEventListener("message", (event) => receive(event.data));
      worker.addEventListener("error", (event) => receive({ type: "unusable", text: event.message || "it permits no worker" }));
      return (message) => worker.postMessage(message);
    } catch {
      const script = document.createElement("script");
      script.textContent = code;
      document.head.append(script);
      return window.makeGelenkWorker(receive);
    }
  }

  // What has been computed, as far as it is kept: a row for each frame.
  Gelenk.csvOf = function ({ time, signals }) {
    const quoted = (name) => (/[",]/.test(name) ? `"${name.replace(/"/g, '""')}"` : name);
    const rows = Array.from(time, (t, k) => [t, ...signals.map(({ values }) => values[k])].join(","));
    return [["time", ...signals.map(({ name }) => quoted(name))].join(","), ...rows, ""].join("\n");
  };

  function save(text, file) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
    link.download = file;
    link.click();
    URL.revokeObjectURL(link.href);
  }

  Gelenk.Computation = class {
    constructor({ recording, player, live, panel, redraw }) {
      Object.assign(this, { recording, player, live, panel, redraw });
      this.started = false;
      this.events = [];
      this.settings = new Gelenk.Settings(recording.computes, (name, value) => this.send({ type: "set", name, value }));
      this.send = startWorker((message) => this[message.type](message));
      this.takePlayer();
      for (const id of ["single", "reset", "events", "export"]) element(id).hidden = false;
      element("save-csv").addEventListener("click", () => {
        save(Gelenk.csvOf(recording), recording.computes.file.replace(/\.json$/, ".csv"));
      });
      element("loop").hidden = true;
      document.documentElement.classList.add("computes");
      const button = element("show-panel");
      button.textContent = "Panel";
      button.title = "Inputs, parameters and plots (P)";
      button.setAttribute("aria-label", "Inputs, parameters and plots");
      element("mark").addEventListener("click", () => this.mark());
      element("return").addEventListener("click", () => this.returnToMark());
      element("save-scene").addEventListener("click", () => this.send({ type: "writeScene" }));
      element("single").addEventListener("click", () => this.singleStep());
      element("reset").addEventListener("click", () => this.reset());
      element("speed").addEventListener("change", () => this.send({ type: "setSpeed", speed: player.speed }));
      player.speed = 1;
      element("speed").value = "1";
      this.listEvents();
      this.send({ type: "start", core: element("core").textContent, ...recording.computes });
      element("core").remove();
    }

    // Playing is computing; whoever looks at the past pauses.
    takePlayer() {
      const { player, live } = this;
      const show = player.show;
      player.advance = () => {};
      player.play = () => this.play();
      player.pause = () => this.pause();
      player.show = (k) => {
        this.pause();
        if (k >= this.recording.frames - 1) live.setFollowing(true);
        else show(k);
      };
    }

    play() {
      this.player.playing = true;
      this.live.setFollowing(true);
      this.hideNotice();
      this.send({ type: "play" });
    }

    pause() {
      if (!this.player.playing) return;
      this.player.playing = false;
      this.showRate(1);
      this.send({ type: "pause" });
      this.redraw();
    }

    singleStep() {
      this.pause();
      this.live.setFollowing(true);
      this.hideNotice();
      this.send({ type: "single" });
    }

    reset() {
      this.hideNotice();
      this.send({ type: "reset" });
    }

    mark() {
      this.send({ type: "mark" });
    }

    returnToMark() {
      if (!element("return").disabled) this.send({ type: "returnToMark" });
    }

    pull(body, point, target) {
      if (!this.player.playing) this.play();
      this.send({ type: "pull", body, point, target });
    }

    letGo() {
      this.send({ type: "release" });
    }

    showNotice(text) {
      element("notice").textContent = text;
      element("notice").hidden = false;
    }

    hideNotice() {
      element("notice").hidden = true;
    }

    showRate(rate) {
      element("rate").hidden = rate > slow;
      element("rate").textContent = `computes at ${rate.toPrecision(2)} of this speed`;
    }

    listEvents() {
      const list = element("event-list");
      const before = list.childElementCount;
      const shown = this.events.slice(-mostEvents);
      if (!this.events.length) list.replaceChildren();
      const fresh = this.events.slice(Math.max(this.listed || 0, this.events.length - mostEvents));
      for (const { t, text } of fresh) {
        const item = document.createElement("li");
        item.textContent = `${t.toFixed(4)} s: ${text}`;
        list.prepend(item);
      }
      while (list.childElementCount > shown.length) list.lastChild.remove();
      this.listed = this.events.length;
      element("event-count").textContent = `(${this.events.length})`;
    }

    // Messages of the worker.

    ready({ variables, warnings, duration }) {
      this.duration = duration;
      const units = new Map(variables.map(({ name, unit }) => [name, unit]));
      this.factors = this.recording.signals.map(({ name, unit }) => (
        unit.startsWith("deg") && (units.get(name) || "").startsWith("rad") ? 1 / degree : 1
      ));
      this.settings.fill(variables);
      this.warn(warnings);
      if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches) this.play();
    }

    warn(warnings) {
      if (warnings.length) this.showNotice(warnings.join("\n"));
    }

    restarted({ warnings }) {
      this.events = [];
      this.listed = 0;
      this.listEvents();
      this.live.clear();
      this.hideNotice();
      this.warn(warnings);
    }

    frame({ time, numbers, events, rate, memory }) {
      const first = 7 * this.recording.bodies.length;
      this.factors.forEach((factor, i) => { numbers[first + i] *= factor; });
      if (!this.started) this.live.clear();
      this.started = true;
      this.memory = memory;
      this.live.receive([time], numbers);
      if (events.length) {
        this.events.push(...events);
        this.listEvents();
        this.player.passed(events[events.length - 1]);
      }
      if (this.player.playing) this.showRate(rate);
    }

    marked({ time }) {
      element("return").disabled = false;
      element("return").textContent = `Back to ${time.toFixed(3)} s`;
    }

    returned({ time, settings }) {
      this.events = this.events.filter(({ t }) => t <= time);
      this.listed = 0;
      element("event-list").replaceChildren();
      this.listEvents();
      this.hideNotice();
      this.settings.show(settings);
      this.live.rewind(time);
    }

    written({ text }) {
      this.sceneText = text;
      save(text, this.recording.computes.file);
    }

    accepted({ name }) {
      this.settings.accept(name);
    }

    refused({ name, text }) {
      if (name) this.settings.refuse(name, text);
      else this.showNotice(text);
    }

    failed({ text }) {
      this.player.playing = false;
      this.showNotice(text);
      this.redraw();
    }

    unusable({ text }) {
      this.failed({ text: `This browser cannot simulate the mechanism: ${text}` });
      for (const id of ["play", "single", "reset"]) element(id).disabled = true;
    }
  };
})();
