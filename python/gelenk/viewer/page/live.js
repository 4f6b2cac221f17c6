// SPDX-License-Identifier: BSD-3-Clause
// Receives the frames of a running simulation.
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
      const source = new EventSource("frames");
      source.addEventListener("message", (event) => this.receive(JSON.parse(event.data)));
      source.addEventListener("end", () => this.end(source));
      source.addEventListener("error", () => this.end(source));
    }

    setFollowing(on) {
      this.following = on && !this.ended;
      if (this.following) this.player.playing = false;
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

    receive(message) {
      const { recording } = this;
      const times = Gelenk.decode(message.time, Float64Array);
      const numbers = Gelenk.decode(message.numbers, Float32Array);
      const size = 7 * recording.bodies.length;
      const row = size + this.values.length;
      this.time.append(times);
      for (let k = 0; k < times.length; k++) {
        this.poses.append(numbers.subarray(k * row, k * row + size));
        this.values.forEach((values, i) => values.append([numbers[k * row + size + i]]));
      }
      if (this.time.view.length > mostFrames) this.forget();
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

    forget() {
      const count = mostFrames / 2;
      this.time.forget(count);
      this.poses.forget(7 * this.recording.bodies.length * count);
      for (const values of this.values) values.forget(count);
      this.player.frame = Math.max(0, this.player.frame - count);
    }

    moveToEnd() {
      if (!this.following) return;
      const { player, recording } = this;
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
