// SPDX-License-Identifier: BSD-3-Clause
// The core as WebAssembly: GelenkCore.load(bytes) makes plants of scenes, with the variables and messages of FMUs.
// fmu/page/page_core.cpp has the functions that are called here.
(function () {
  "use strict";

  const causalities = ["input", "output", "parameter", "local", "independent"];
  const variabilities = ["continuous", "discrete", "fixed", "tunable"];
  const types = ["real", "boolean", "enumeration", "integer"];
  const badFile = 8;  // WASI: no file exists here

  // A module that has ended must not be called again; the scene may be loaded by another one.
  class CoreFailure extends Error {}

  // What the C library asks of its system: a clock, random numbers, and nothing else.
  function system(memory) {
    const view = () => new DataView(memory().buffer);
    const none = (count, size) => {
      view().setUint32(count, 0, true);
      view().setUint32(size, 0, true);
      return 0;
    };
    return {
      clock_time_get(id, precision, to) {
        view().setBigUint64(to, BigInt(Math.round(performance.now() * 1e6)), true);
        return 0;
      },
      random_get(to, count) {
        crypto.getRandomValues(new Uint8Array(memory().buffer, to, count));
        return 0;
      },
      environ_sizes_get: none,
      args_sizes_get: none,
      environ_get: () => 0,
      args_get: () => 0,
      fd_write(file, parts, count, to) {
        let written = 0;
        for (let i = 0; i < count; i++) written += view().getUint32(parts + 8 * i + 4, true);
        view().setUint32(to, written, true);
        return 0;
      },
      proc_exit(code) {
        throw new CoreFailure(`the core has ended with code ${code}`);
      }
    };
  }

  class Module {
    constructor(instance) {
      this.functions = instance.exports;
      this.functions._initialize();
    }

    get buffer() {
      return this.functions.memory.buffer;
    }

    text(at) {
      const bytes = new Uint8Array(this.buffer);
      return new TextDecoder().decode(bytes.slice(at, bytes.indexOf(0, at)));
    }

    // Calls `use` with the address of a copy of the bytes, which is released afterwards.
    withBytes(bytes, use) {
      const at = this.functions.gelenk_reserve(Math.max(1, bytes.length));
      new Uint8Array(this.buffer).set(bytes, at);
      try {
        return use(at);
      } finally {
        this.functions.gelenk_release(at);
      }
    }

    withText(text, use) {
      return this.withBytes(new TextEncoder().encode(text + "\0"), use);
    }

    // Calls a function of the core. Throws an Error with its message.
    call(name, ...given) {
      let result;
      try {
        result = this.functions[name](...given);
      } catch (error) {
        if (error instanceof CoreFailure) throw error;
        throw new CoreFailure(`the core has failed in ${name}: ${error.message}`);
      }
      if (result < 0) throw new Error(this.text(this.functions.gelenk_error()));
      return result;
    }

    list(count, item) {
      return Array.from({ length: count }, (_, i) => this.text(item(i)));
    }
  }

  class Plant {
    constructor(module, json, file) {
      const { functions } = this.module = module;
      const scene = new TextEncoder().encode(json);
      this.handle = module.withBytes(scene, (at) => module.withText(file, (name) => (
        module.call("gelenk_create", at, scene.length, name)
      )));
      if (!this.handle) throw new Error(module.text(functions.gelenk_error()));
      const number = (index, which) => functions.gelenk_variable_number(this.handle, index, which);
      const text = (index, which) => module.text(functions.gelenk_variable_text(this.handle, index, which));
      this.variables = Array.from({ length: functions.gelenk_variables(this.handle) }, (_, index) => ({
        index,
        name: text(index, 0),
        unit: text(index, 1),
        description: text(index, 2),
        causality: causalities[number(index, 0)],
        variability: variabilities[number(index, 1)],
        type: types[number(index, 2)],
        start: number(index, 3),
        min: number(index, 4),
        max: number(index, 5),
        hidden: number(index, 6) === 1
      }));
      this.byName = new Map(this.variables.map((variable) => [variable.name, variable]));
      this.bodies = functions.gelenk_bodies(this.handle);
      this.room = functions.gelenk_reserve(8 * (7 * this.bodies + this.variables.length));
      this.indices = functions.gelenk_reserve(4 * this.variables.length);
    }

    call(name, ...given) {
      return this.module.call(name, this.handle, ...given);
    }

    index(name) {
      const variable = this.byName.get(name);
      if (!variable) throw new Error(`${name}: found no variable of this name`);
      return variable.index;
    }

    get time() {
      return this.module.functions.gelenk_time(this.handle);
    }

    // Closes the loops at the start values. tolerance: 0 is that of the scene.
    initialize(time = 0, tolerance = 0) {
      this.call("gelenk_initialize", time, tolerance);
      return this.module.list(this.call("gelenk_warnings"), (i) => this.call("gelenk_warning", i));
    }

    // An input, or a parameter before initialize().
    set(name, value) {
      this.call("gelenk_set", this.index(name), value);
    }

    // A tunable parameter of a run.
    tune(name, value) {
      this.call("gelenk_tune", this.index(name), value);
    }

    setDerivative(name, order, value) {
      this.call("gelenk_set_derivative", this.index(name), order, value);
    }

    // Values of variables, by their numbers.
    values(indices) {
      new Int32Array(this.module.buffer, this.indices, indices.length).set(indices);
      this.call("gelenk_get", this.indices, indices.length, this.room);
      return new Float64Array(this.module.buffer, this.room, indices.length).slice();
    }

    value(name) {
      return this.values([this.index(name)])[0];
    }

    // Of each body: position and quaternion (x, y, z, w).
    poses() {
      this.call("gelenk_poses", this.room);
      return new Float64Array(this.module.buffer, this.room, 7 * this.bodies).slice();
    }

    // Advances to a time, and returns the events on the way.
    stepTo(end) {
      this.call("gelenk_step_to", end);
      return Array.from({ length: this.call("gelenk_events") }, (_, i) => ({
        t: this.module.functions.gelenk_event_time(this.handle, i),
        text: this.module.text(this.call("gelenk_event_text", i))
      }));
    }

    // The scene with the parameters that are set, as JSON.
    scene() {
      this.call("gelenk_write_scene");
      return this.module.text(this.call("gelenk_scene"));
    }

    // All that determines how the run continues.
    save() {
      const count = this.call("gelenk_save");
      return new BigUint64Array(this.module.buffer, this.call("gelenk_saved"), count).slice();
    }

    restore(saved) {
      this.module.withBytes(new Uint8Array(saved.buffer), (at) => this.call("gelenk_restore", at, saved.length));
    }

    free() {
      const { module } = this;
      try {
        module.call("gelenk_release", this.room);
        module.call("gelenk_release", this.indices);
        module.call("gelenk_destroy", this.handle);
      } catch (error) {
        if (!(error instanceof CoreFailure)) throw error;  // the memory of a module that has failed is gone with it
      }
    }
  }

  class Core {
    constructor(compiled) {
      this.compiled = compiled;
    }

    async start() {
      let instance = null;
      const offered = system(() => instance.exports.memory);
      const functions = WebAssembly.Module.imports(this.compiled).map(({ name }) => [name, offered[name] || (() => badFile)]);
      instance = await WebAssembly.instantiate(this.compiled, { wasi_snapshot_preview1: Object.fromEntries(functions) });
      this.module = new Module(instance);
      return this;
    }

    // Throws an Error with the messages of the reader.
    plant(json, file = "scene.json") {
      return new Plant(this.module, json, file);
    }

    get memory() {
      return this.module.buffer.byteLength;
    }
  }

  globalThis.GelenkCore = {
    CoreFailure,
    load: async (bytes) => new Core(await WebAssembly.compile(bytes)).start()
  };
})();
