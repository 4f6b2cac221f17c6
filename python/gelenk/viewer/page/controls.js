// SPDX-License-Identifier: BSD-3-Clause
// The player bar, the buttons, and the keyboard.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  const element = (id) => document.getElementById(id);
  const icons = { play: "M4 2 L14 8 L4 14 Z", pause: "M3 2 h4 v12 h-4 Z M9 2 h4 v12 h-4 Z" };
  const markNames = { event: "Event", singular: "Singular configuration", end: "End of the run" };
  const messageDuration = 2500;

  // After a choice with the mouse the keys belong to the player again; who came by keyboard stays.
  function releaseAfterPointer(select) {
    let byPointer = false;
    select.addEventListener("pointerdown", () => { byPointer = true; });
    select.addEventListener("keydown", () => { byPointer = false; });
    select.addEventListener("change", () => { if (byPointer) select.blur(); });
  }

  Gelenk.PlayerBar = class {
    constructor(recording, player) {
      Object.assign(this, { recording, player });
      this.digits = this.timeDigits();
      if (recording.frames < 2 && !recording.live) return;
      element("player").hidden = false;
      this.slider = element("slider");
      this.slider.max = String(recording.frames - 1);
      this.slider.addEventListener("input", () => player.show(this.slider.valueAsNumber));
      element("play").addEventListener("click", () => player.toggle());
      element("loop").addEventListener("click", () => {
        player.loop = !player.loop;
        element("loop").setAttribute("aria-pressed", String(player.loop));
      });
      this.fillSpeeds();
      this.addMarks();
      element("time").style.minWidth = this.timeText(recording.time[recording.frames - 1]).length + "ch";
    }

    // Enough digits to distinguish neighboring frames, at least three.
    timeDigits() {
      const { time, frames } = this.recording;
      const step = frames > 1 && time[frames - 1] > time[0] ? (time[frames - 1] - time[0]) / (frames - 1) : 1;
      return Math.min(9, Math.max(3, Math.ceil(-Math.log10(step) - 1e-9)));
    }

    timeText(t) {
      return `t = ${t.toFixed(this.digits).replace("-", "\u2212")} s`;
    }

    // Call when frames have been added.
    extend() {
      this.slider.max = String(this.recording.frames - 1);
      this.digits = this.timeDigits();
    }

    // Call when the times of the recording have become others.
    measure() {
      this.digits = this.timeDigits();
      element("speed").replaceChildren();
      this.addSpeeds();
    }

    fillSpeeds() {
      this.addSpeeds();
      element("speed").addEventListener("change", () => {
        this.player.speed = Number(element("speed").value);
      });
      releaseAfterPointer(element("speed"));
    }

    addSpeeds() {
      const speeds = [...new Set([...Gelenk.speeds, this.player.speed])].sort((a, b) => a - b);
      for (const speed of speeds) {
        const chosen = speed === this.player.speed;
        element("speed").append(new Option(speed + "\u00d7", String(speed), chosen, chosen));
      }
    }

    // Events closer together than a mark is wide share one.
    addMarks() {
      const { time, frames, events } = this.recording;
      const groups = [];
      for (const event of events) {
        const { index, fraction } = Gelenk.locate(time, event.t);
        const share = (index + fraction) / (frames - 1);
        const last = groups[groups.length - 1];
        const kind = event.kind || "event";
        if (last && last.kind === kind && share - last.share < 0.008) last.events.push(event);
        else groups.push({ share, kind, events: [event] });
      }
      for (const group of groups) this.addMark(group);
    }

    addMark({ share, kind, events }) {
      const mark = document.createElement("button");
      const lines = events.slice(0, 8).map((event) => `${this.timeText(event.t)}: ${event.text}`);
      if (events.length > 8) lines.push(`and ${events.length - 8} more`);
      const text = lines.join("\n");
      mark.type = "button";
      mark.className = "mark " + kind;
      mark.style.left = `${100 * share}%`;
      mark.setAttribute("aria-label", markNames[kind] + " " + text);
      const show = () => this.showTip(mark, text);
      const hide = () => { element("tip").hidden = true; };
      mark.addEventListener("pointerenter", show);
      mark.addEventListener("focus", show);
      mark.addEventListener("pointerleave", hide);
      mark.addEventListener("blur", hide);
      mark.addEventListener("click", () => {
        this.player.showTime(events[0].t);
        this.showEvent(events[0]);
        show();
      });
      element("marks").append(mark);
    }

    showTip(mark, text) {
      const tip = element("tip");
      tip.textContent = text;
      tip.hidden = false;
      const box = mark.getBoundingClientRect();
      const middle = box.left + box.width / 2 - tip.offsetWidth / 2;
      tip.style.left = `${Math.max(4, Math.min(window.innerWidth - tip.offsetWidth - 4, middle))}px`;
      tip.style.top = `${box.top - tip.offsetHeight - 6}px`;
    }

    showEvent(event) {
      element("event").textContent = event.text;
      element("event").classList.add("shown");
      clearTimeout(this.timer);
      this.timer = setTimeout(() => element("event").classList.remove("shown"), messageDuration);
    }

    update() {
      if (!this.slider) return;
      const { player } = this;
      const text = this.timeText(player.time);
      element("time").textContent = text;
      this.slider.value = String(player.frame);
      this.slider.setAttribute("aria-valuetext", text);
      if (this.playing === player.playing) return;
      this.playing = player.playing;
      element("play-icon").setAttribute("d", this.playing ? icons.pause : icons.play);
      element("play").setAttribute("aria-label", this.playing ? "Pause" : "Play");
    }
  };

  // A button that switches something on and off; returns the function to do so.
  Gelenk.toggleButton = function (id, isOn, setOn) {
    const button = element(id);
    const mark = () => button.setAttribute("aria-pressed", String(isOn()));
    const toggle = () => {
      setOn(!isOn());
      mark();
    };
    button.addEventListener("click", toggle);
    mark();
    return toggle;
  };

  const keys = [
    ["Space", "play or pause"],
    ["\u2190 \u2192", "one frame back or on; with Shift ten"],
    ["Home End", "first or last frame"],
    ["1 2 3 4", "view from the front, the side, the top, as at the start"],
    ["F", "fit the mechanism into the view"],
    ["C", "camera follows the mechanism, or does not move"],
    ["+ \u2212", "zoom in or out"],
    ["L", "labels"], ["T", "trails"], ["X", "axes of frames"], ["V", "forces and torques"], ["P", "plots"], ["D", "dark or light"], ["?", "this help"],
    ["Drag", "rotate; one finger"],
    ["Right or Shift drag", "move; two fingers"],
    ["Wheel", "zoom; pinch"]
  ];

  Gelenk.setUpHelp = function (version) {
    for (const [key, meaning] of keys) {
      const term = document.createElement("dt");
      const definition = document.createElement("dd");
      term.textContent = key;
      definition.textContent = meaning;
      element("keys").append(term, definition);
    }
    element("version").textContent = version ? `Made with ${version}.` : "";
    const dialog = element("help");
    const toggle = () => (dialog.open ? dialog.close() : dialog.showModal());
    element("help-open").addEventListener("click", toggle);
    dialog.addEventListener("click", (event) => { if (event.target === dialog) dialog.close(); });
    return toggle;
  };

  // `actions` maps the names of keys, letters in lower case, to functions of the event.
  Gelenk.listenToKeys = function (actions) {
    // A button keeps the focus when clicked and would take the space bar from the player.
    document.addEventListener("click", (event) => {
      const button = event.target.closest("button");
      if (button && event.detail > 0) button.blur();
    });
    document.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented) return;
      const { target } = event;
      const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
      if (element("help").open && key !== "?") return;
      if (target.matches("input[type=search], select, textarea")) return;
      // Buttons, check boxes, and summaries answer to the space bar themselves.
      if (key === " " && target.matches("button, summary, input[type=checkbox]")) return;
      if (!Object.prototype.hasOwnProperty.call(actions, key)) return;
      event.preventDefault();
      actions[key](event);
    });
  };
})();
