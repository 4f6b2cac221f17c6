// SPDX-License-Identifier: BSD-3-Clause
// Forces by which a pointer pulls a body, and the change from a plant to another one in the midst of a run.
(function () {
  "use strict";

  const names = { spring: "pulled__spring", force: "pulled__force" };
  const dampingRatio = 0.4;

  // The scene with a spring and a damper from a point of a body to the origin, and a force that moves the other end
  // elsewhere: k (target - p) - c v. As elements of the scene they are part of the equations that are integrated.
  function pulledScene(json, { body, point, stiffness, mass }) {
    const scene = JSON.parse(json);
    const damping = 2 * dampingRatio * Math.sqrt(stiffness * mass);
    const forces = {
      [names.spring]: {
        type: "bushing", from: "ground", to: { body, position: point },
        stiffness: [stiffness, stiffness, stiffness], damping: [damping, damping, damping]
      },
      [names.force]: { type: "wrench", body, position: point, force: [0, 0, 0], input: true }
    };
    return JSON.stringify({ ...scene, forces: { ...scene.forces, ...forces } });
  }

  function setTarget(plant, stiffness, target) {
    target.forEach((x, i) => plant.set(`${names.force}.f[${i + 1}]`, stiffness * x));
  }

  // Starts a plant where another one is: with its coordinates, velocities and states as start values, and its inputs.
  function startFrom(plant, other) {
    for (const { name, causality, variability } of plant.variables) {
      if (causality === "input" && other.byName.has(name)) plant.set(name, other.value(name));
      if (causality !== "parameter" || !other.byName.has(name)) continue;
      const state = name.replace(/_start(\[\d+\])?$/, "$1");
      if (state !== name && other.byName.has(state)) plant.set(name, other.value(state));
      else if (name === "solver.start") plant.set(name, 1);  // as given
      else plant.set(name, other.value(name));
    }
    return plant.initialize(other.time);
  }

  globalThis.GelenkPull = { names, pulledScene, setTarget, startFrom };
})();
