// SPDX-License-Identifier: BSD-3-Clause
// The state of the playback: where in the run we are and how fast time advances.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  // After a pause of the browser, as with a hidden tab, playing continues where it was.
  const longestStep = 0.25;

  Gelenk.speeds = [0.05, 0.1, 0.25, 0.5, 1, 2, 5];

  // Real speed, or for a short run one that lets it last from 2 to 4 seconds.
  Gelenk.initialSpeed = function (duration) {
    if (!(duration > 0) || duration >= 2) return 1;
    const fits = (speed) => duration / speed >= 2 && duration / speed <= 4;
    return Gelenk.speeds.slice().reverse().find(fits) || Number((duration / 3).toPrecision(2));
  };

  Gelenk.Player = class {
    // `changed` is called after every change of state, `passed` with the last event passed by.
    constructor(recording, changed, passed) {
      Object.assign(this, { recording, changed, passed });
      this.measure();
      this.loop = true;
      this.playing = false;
      this.time = this.first;
      this.frame = 0;
      this.fraction = 0;
    }

    // Call when the times of the recording have become others.
    measure() {
      const { recording } = this;
      const before = this.last - this.first;
      this.first = recording.time[0];
      this.last = recording.time[recording.frames - 1];
      if (this.speed && (recording.live || this.last - this.first === before)) return;
      this.speed = Gelenk.initialSpeed(this.last - this.first);
      if (this.frame !== undefined) this.time = recording.time[this.frame];
    }

    show(k) {
      const { recording } = this;
      const before = this.time;
      this.frame = Math.min(recording.frames - 1, Math.max(0, Math.round(Number(k) || 0)));
      this.fraction = 0;
      this.time = recording.time[this.frame];
      this.report(before);
      this.changed();
    }

    showTime(t) {
      this.show(Gelenk.nearestIndex(this.recording.time, t));
    }

    play() {
      if (this.recording.frames < 2) return;
      if (this.time >= this.last) this.show(0);
      this.playing = true;
      this.clock = null;
      this.changed();
    }

    // Comes to rest exactly on a frame, so that what is seen was computed and not interpolated.
    pause() {
      this.playing = false;
      this.showTime(this.time);
    }

    toggle() {
      if (this.playing) this.pause();
      else this.play();
    }

    // Continues by the time since the last call; `now` in milliseconds.
    advance(now) {
      const step = this.clock === null ? 0 : Math.min(longestStep, (now - this.clock) / 1000);
      this.clock = now;
      const before = this.time;
      this.time += step * this.speed;
      if (this.time >= this.last) {
        if (!this.loop) {
          this.time = this.last;
          this.pause();
          this.report(before);
          return;
        }
        this.time = this.first + (this.time - this.last) % (this.last - this.first);
      }
      const { index, fraction } = Gelenk.locate(this.recording.time, this.time);
      this.frame = index;
      this.fraction = fraction;
      this.report(before);
      this.changed();
    }

    report(before) {
      if (this.time <= before) return;
      const { events } = this.recording;
      for (let i = events.length - 1; i >= 0; i--) {
        if (events[i].t > this.time) continue;
        if (events[i].t > before) this.passed(events[i]);
        return;
      }
    }
  };
})();
