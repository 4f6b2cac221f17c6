// SPDX-License-Identifier: BSD-3-Clause
// Keeps the frames of a running simulation, which a server sends or the page computes.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  const mostFrames = 20000;  // then the older half is forgotten
  const chartPeriod = 250;  // ms between redrawing the curves

  // An array that grows; `view` is what it contains.
  class Growing {
    constructor(first) {
      this.array = first.slice();
      this.view = this.array;
    }

    append(numbers) {
      const used = this.view.length;
      if (used + numbers.length > this.array.length) {
        const larger = new this.array.constructor(2 * (used + numbers.length));
        larger.set(this.view);
        this.array = larger;
      }
      this.array.set(numbers, used);
      this.view = this.array.subarray(0, used + numbers.length);
    }

    keep(count) {
      this.view = this.array.subarray(0, count);
    }

    forget(count) {
      this.array = this.view.slice(count);
      this.view = this.array;
    }
  }

  Gelenk.Live = class {
    // `grown` is called some times a second when frames have been added.
    constructor(recording, player, playerBar, panel, redraw, grown) {
      Object.assign(this, { recording, player, playerBar, panel, redraw, grown });
      this.following = true;
      this.time = new Growing(recording.time);
      this.poses = new Growing(recording.poses);
      this.values = recording.signals.map((signal) => new Growing(signal.values));
      this.timer = 0;
      this.button = document.getElementById("live");
      this.button.hidden = false;
      this.button.addEventListener("click", () => this.setFollowing(true));
      // Whoever moves the slider or plays looks at the past.
      for (const name of ["show", "play"]) {
        const act = player[name].bind(player);
        player[name] = (...given) => {
          this.setFollowing(false);
          act(...given);
        };
      }
      this.setFollowing(true);
      if (!recording.computes) this.listen();
    }

    listen() {
      const source = new EventSource("frames");
      source.addEventListener("message", (event) => {
        const { time, numbers } = JSON.parse(event.data);
        this.receive(Gelenk.decode(time, Float64Array), Gelenk.decode(numbers, Float32Array));
      });
      source.addEventListener("end", () => this.end(source));
      source.addEventListener("error", () => this.end(source));
    }

    setFollowing(on) {
      this.following = on && !this.ended;
      if (this.following && !this.recording.computes) this.player.playing = false;
      this.button.setAttribute("aria-pressed", String(this.following));
      this.moveToEnd();
      this.redraw();
    }

    end(source) {
      source.close();
      this.ended = true;
      this.following = false;
      this.button.disabled = true;
      this.button.textContent = "Ended";
      this.button.setAttribute("aria-pressed", "false");
      this.chart();
      this.redraw();
    }

    // numbers: poses and signals of each of the times.
    receive(times, numbers) {
      const { recording } = this;
      const size = 7 * recording.bodies.length;
      const row = size + this.values.length;
      this.time.append(times);
      for (let k = 0; k < times.length; k++) {
        this.poses.append(numbers.subarray(k * row, k * row + size));
        this.values.forEach((values, i) => values.append([numbers[k * row + size + i]]));
      }
      if (this.time.view.length > mostFrames) this.forget(mostFrames / 2);
      this.publish();
    }

    publish() {
      const { recording } = this;
      recording.time = this.time.view;
      recording.frames = this.time.view.length;
      recording.poses = this.poses.view;
      recording.signals.forEach((signal, i) => { signal.values = this.values[i].view; });
      this.player.measure();
      this.playerBar.extend();
      this.moveToEnd();
      if (!this.timer) this.timer = setTimeout(() => this.chart(), chartPeriod);
      this.redraw();
    }

    // Drops the frames after a time.
    rewind(time) {
      const count = Gelenk.indexBefore(this.time.view, time) + 1;
      this.time.keep(count);
      this.poses.keep(7 * this.recording.bodies.length * count);
      for (const values of this.values) values.keep(count);
      this.publish();
      this.setFollowing(true);
    }

    // Begins a new run.
    clear() {
      this.forget(this.time.view.length);
      this.setFollowing(true);
    }

    forget(count) {
      this.time.forget(count);
      this.poses.forget(7 * this.recording.bodies.length * count);
      for (const values of this.values) values.forget(count);
      this.player.frame = Math.max(0, this.player.frame - count);
    }

    moveToEnd() {
      const { player, recording } = this;
      if (!this.following || !this.time.view.length) return;
      player.frame = recording.frames - 1;
      player.fraction = 0;
      player.time = recording.time[player.frame];
    }

    chart() {
      clearTimeout(this.timer);
      this.timer = 0;
      this.panel.extend();
      this.grown();
    }
  };
})();
