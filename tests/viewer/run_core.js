// SPDX-License-Identifier: BSD-3-Clause
// node run_core.js CORE: carries out a list of jobs, JSON on standard input, with the core as a page runs it, and writes
// the list of their answers. The files of python/gelenk/viewer/worker are loaded as a page loads them.
"use strict";
const fs = require("fs");
const path = require("path");
const vm = require("vm");
const zlib = require("zlib");

const [, , coreFile, worker] = process.argv;
for (const name of fs.readdirSync(worker).filter((file) => file.endsWith(".js")).sort()) {
  vm.runInThisContext(fs.readFileSync(path.join(worker, name), "utf8"), { filename: name });
}

const jobs = {
  // Rows of all outputs at the times, and the events.
  run(core, { scene, file, times, inputs = {}, tolerance = 0 }) {
    const plant = core.plant(scene, file);
    const outputs = plant.variables.filter(({ causality }) => causality === "output");
    for (const [name, value] of Object.entries(inputs)) plant.set(name, value);
    const warnings = plant.initialize(0, tolerance);
    const indices = outputs.map(({ index }) => index);
    const rows = [[...plant.values(indices)]];
    const events = [];
    for (const time of times) {
      events.push(...plant.stepTo(time));
      rows.push([...plant.values(indices)]);
    }
    const out = { names: outputs.map(({ name }) => name), rows, events, warnings, poses: [...plant.poses()] };
    plant.free();
    return out;
  },

  // What is said of a scene, and whether the core works afterwards.
  fault(core, { scene, file }) {
    try {
      const plant = core.plant(scene, file);
      plant.initialize();
      plant.free();
      return null;
    } catch (error) {
      if (error instanceof GelenkCore.CoreFailure) throw error;
      return error.message;
    }
  },

  variables(core, { scene }) {
    const plant = core.plant(scene);
    const out = plant.variables;
    plant.free();
    return out;
  },

  // A run that is saved in its midst, and continued from there several times.
  restored(core, { scene, before, after }) {
    const plant = core.plant(scene);
    plant.initialize();
    plant.stepTo(before);
    const saved = plant.save();
    const ends = [];
    for (let k = 0; k < 3; k++) {
      plant.stepTo(after);
      ends.push([...plant.poses()]);
      plant.restore(saved);
      ends.push(plant.time);
    }
    plant.free();
    return ends;
  },

  // The messages of a session that receives the given ones; a number is milliseconds that pass.
  session(core, { start, messages }) {
    const posted = [];
    const session = new GelenkSession(core, start, (message) => {
      posted.push({ ...message, numbers: message.numbers && [...message.numbers] });
    });
    session.begin();
    for (const message of messages) {
      if (typeof message === "number") for (let t = 0; t < message; t += 20) session.tick(20);
      else session[message.type](message);
    }
    posted.push({ type: "end", time: session.plant.time, memory: core.memory });
    return posted;
  }
};

// A session whose core fails in its midst.
jobs.failing = async function (core, { start }) {
  const posted = [];
  const session = new GelenkSession(core, start, ({ type, text, time }) => posted.push({ type, text, time }));
  session.begin();
  session.play();
  session.tick(50);
  session.plant.stepTo = () => { throw new GelenkCore.CoreFailure("the core has failed"); };
  try {
    session.tick(50);
  } catch (error) {
    await session.recover(error);
  }
  session.play();
  session.tick(50);
  return posted;
};

(async function () {
  const list = JSON.parse(fs.readFileSync(0, "utf8"));
  const core = await GelenkCore.load(zlib.gunzipSync(fs.readFileSync(coreFile)));
  const answers = [];
  for (const { job, ...given } of list) answers.push(await jobs[job](core, given));
  fs.writeFileSync(1, JSON.stringify(answers));
})();
