// SPDX-License-Identifier: BSD-3-Clause
// A run that a page controls: it advances with the clock, and is assembled again when a parameter has changed.
(function () {
  "use strict";

  const framesPerSecond = 60;
  const ordinaryBudget = 25;  // ms of computation before a frame is sent
  const longestGap = 100;  // ms of the clock that are made up for

  globalThis.GelenkSession = class {
    // scene: JSON text; file: its name in messages; step: of communication [s]; signals: names of outputs that frames
    // have beside the poses; settings: values by name; pull: mass [kg] and stiffness [N/m] of the pointer's spring;
    // post: is called with messages; budget: computation before a frame is sent [ms].
    constructor(core, { scene, file, step, signals, settings, pull, budget = ordinaryBudget }, post) {
      Object.assign(this, { core, scene, file, step, signals, post, budget });
      this.spring = pull;
      this.first = this.settings = { ...settings };
      this.speed = 1;
      this.playing = false;
      this.pulled = null;
      this.rate = 1;
    }

    // Makes a plant with the present settings and assembles it. Throws an Error, and then has changed nothing.
    begin(settings = this.settings) {
      const plant = this.core.plant(this.scene, this.file);
      try {
        for (const [name, value] of Object.entries(settings)) plant.set(name, value);
        const warnings = plant.initialize();
        this.settings = settings;
        this.pulled = null;
        this.use(plant);
        return warnings;
      } catch (error) {
        plant.free();
        throw error;
      }
    }

    use(plant) {
      if (this.plant) this.plant.free();
      this.plant = plant;
      this.columns = this.signals.map((name) => plant.index(name));
      this.setGrid();
    }

    // The grid is that of the scene, divided where frames need it. Times are multiples, so that they do not drift.
    setGrid() {
      const { step, speed } = this;
      this.origin = this.plant.time;
      this.count = 0;
      this.length = step / Math.max(1, Math.ceil(step * framesPerSecond / Math.min(1, speed) - 1e-9));
      this.due = this.origin;
    }

    restart(settings) {
      const warnings = this.begin(settings);
      this.post({ type: "restarted", warnings, settings: this.settings });
      this.send([]);
    }

    frame() {
      return { time: this.plant.time, poses: this.plant.poses(), values: this.plant.values(this.columns) };
    }

    send(events) {
      const { time, poses, values } = this.frame();
      const numbers = new Float32Array(poses.length + values.length);
      numbers.set(poses);
      numbers.set(values, poses.length);
      this.post({ type: "frame", time, numbers, events, rate: this.rate, memory: this.core.memory });
    }

    advance() {
      const events = this.plant.stepTo(this.origin + (this.count + 1) * this.length);
      this.count++;
      return events;
    }

    // Advances by the time of the clock since the last call [ms], as far as it can be computed in time.
    tick(elapsed) {
      if (!this.playing) return;
      const wanted = Math.min(elapsed, longestGap) / 1000 * this.speed;
      const before = this.plant.time;
      const begin = performance.now();
      const events = [];
      this.due = Math.max(this.due, before) + wanted;
      try {
        while (this.plant.time + this.length <= this.due + 1e-12) {
          events.push(...this.advance());
          if (performance.now() - begin <= this.budget) continue;
          this.due = this.plant.time;  // what cannot be computed in time is not made up for
        }
      } catch (error) {
        this.fail(error);
      }
      if (wanted > 0) this.rate += 0.1 * (Math.min(1, (this.plant.time - before) / wanted) - this.rate);
      if (this.plant.time > before || events.length) this.send(events);
    }

    fail(error) {
      if (error instanceof globalThis.GelenkCore.CoreFailure) throw error;
      this.playing = false;
      this.post({ type: "failed", text: error.message });
    }

    // A core that has failed is of no more use. Another one begins at the start, with the first settings.
    async recover(error) {
      this.playing = false;
      this.plant = null;
      await this.core.start();
      this.restart(this.first);
      this.post({ type: "failed", text: error.message });
    }

    // Messages of the page.

    play() {
      this.playing = true;
      this.due = this.plant.time;
    }

    pause() {
      this.playing = false;
    }

    single() {
      this.playing = false;
      try {
        this.send(this.advance());
      } catch (error) {
        this.fail(error);
      }
    }

    setSpeed({ speed }) {
      this.speed = speed;
      this.setGrid();
    }

    reset() {
      this.restart(this.settings);
    }

    // Inputs and tunable parameters change the run; others begin a new one, at the start.
    set({ name, value }) {
      const settings = { ...this.settings, [name]: value };
      try {
        const { causality, variability } = this.plant.byName.get(name) || {};
        if (causality === "input") this.plant.set(name, value);
        else if (variability === "tunable") this.plant.tune(name, value);
        else this.restart(settings);
        this.settings = settings;
        this.post({ type: "accepted", name });
      } catch (error) {
        this.refuse(name, error);
      }
    }

    // Keeps the present state, to which the run may return.
    mark() {
      this.release();
      this.marked = { saved: this.plant.save(), time: this.plant.time, settings: this.settings };
      this.post({ type: "marked", time: this.marked.time });
    }

    returnToMark() {
      this.release();
      this.plant.restore(this.marked.saved);
      this.settings = this.marked.settings;
      this.setGrid();
      this.post({ type: "returned", time: this.plant.time, settings: this.settings });
    }

    writeScene() {
      const plant = this.core.plant(this.scene, this.file);
      try {
        for (const [name, value] of Object.entries(this.settings)) plant.set(name, value);
        this.post({ type: "written", text: plant.scene() });
      } finally {
        plant.free();
      }
    }

    refuse(name, error) {
      if (error instanceof globalThis.GelenkCore.CoreFailure) throw error;
      this.post({ type: "refused", name, text: error.message });
    }

    pull({ body, point, target }) {
      const { stiffness, mass } = this.spring;
      const { pulledScene, setTarget, startFrom } = globalThis.GelenkPull;
      if (!this.pulled) {
        const plant = this.core.plant(pulledScene(this.scene, { body, point, stiffness, mass }), this.file);
        try {
          setTarget(plant, stiffness, target);
          startFrom(plant, this.plant);
        } catch (error) {
          plant.free();
          this.refuse("", error);
          return;
        }
        this.pulled = { body };
        this.use(plant);
      }
      setTarget(this.plant, stiffness, target);
    }

    release() {
      if (!this.pulled) return;
      this.pulled = null;
      const plant = this.core.plant(this.scene, this.file);
      try {
        globalThis.GelenkPull.startFrom(plant, this.plant);
        this.use(plant);
      } catch (error) {
        plant.free();
        this.fail(error);
      }
    }
  };
})();
