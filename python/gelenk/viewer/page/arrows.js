// SPDX-License-Identifier: BSD-3-Clause
// Forces and torques as arrows to scale, and the axes of frames.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  const kinds = ["load", "reaction", "contact"];
  const kindNames = { load: "loads", reaction: "reactions", contact: "contacts" };
  const colors = {
    "load N": "#e8590c", "reaction N": "#1971c2", "contact N": "#2f9e44",
    "load N m": "#f08c00", "reaction N m": "#7048e8", "contact N m": "#0c8599"
  };
  // In radii of the mechanism: the length of an arrow that few exceed, and the sizes of head and shaft.
  const usualLength = 0.6;
  const head = { length: 0.07, radius: 0.022 };
  const shaftRadius = 0.008;
  const usualShare = 0.95;  // of the frames, in which no arrow is longer
  const axisColors = ["#d63031", "#2e9b3f", "#2d62d6"];

  // Arrows are instances of a shaft and of a head: each color costs two draw calls.
  Gelenk.Arrows = class {
    constructor(recording, model) {
      Object.assign(this, { recording, model });
      this.visible = false;
      this.groups = [];
      this.scales = {};
      this.factor = 1;
      for (const unit of ["N", "N m"]) {
        const own = recording.arrows.filter((arrow) => arrow.unit === unit);
        if (own.length) this.scales[unit] = usualLength * model.radius / usualSize(own, recording.frames);
      }
      for (const kind of kinds) {
        for (const unit of ["N", "N m"]) {
          const own = recording.arrows.filter((arrow) => arrow.kind === kind && arrow.unit === unit);
          if (own.length) this.groups.push(this.makeGroup(own, kind, unit));
        }
      }
    }

    get available() {
      return this.groups.length > 0;
    }

    makeGroup(arrows, kind, unit) {
      const { model } = this;
      const color = colors[`${kind} ${unit}`];
      // Forces act on and within bodies, which would hide the arrows.
      const material = model.material("seen through", color);
      // Torques have two heads.
      const heads = unit === "N m" ? 2 : 1;
      const add = (geometry, count) => {
        const mesh = new THREE.InstancedMesh(geometry, material, count);
        mesh.frustumCulled = false;
        mesh.visible = false;
        mesh.renderOrder = 1;
        model.root.add(mesh);
        return mesh;
      };
      const shaft = new THREE.CylinderGeometry(shaftRadius * model.radius, shaftRadius * model.radius, 1, 8);
      shaft.translate(0, 0.5, 0);
      const cone = new THREE.ConeGeometry(head.radius * model.radius, head.length * model.radius, 12);
      cone.translate(0, -0.5 * head.length * model.radius, 0);
      return { arrows, kind, unit, color, heads, shafts: add(shaft, arrows.length), cones: add(cone, heads * arrows.length) };
    }

    setVisible(on) {
      this.visible = on && this.available;
      for (const { shafts, cones } of this.groups) shafts.visible = cones.visible = this.visible;
    }

    // Vector of an arrow between two frames, in its unit.
    vectorAt(arrow, index, fraction, target) {
      const { vectors, scale } = arrow;
      target.fromArray(vectors, 3 * index);
      if (fraction > 0 && 3 * index + 6 <= vectors.length) target.lerp(later.fromArray(vectors, 3 * index + 3), fraction);
      return target.multiplyScalar(scale);
    }

    update(index, fraction) {
      if (!this.visible) return;
      const headLength = head.length * this.model.radius;
      for (const { arrows, unit, heads, shafts, cones } of this.groups) {
        arrows.forEach((arrow, i) => {
          const point = arrow.points ? Array.from(arrow.points.subarray(3 * index, 3 * index + 3)) : arrow.p;
          this.model.worldPoint(arrow.body, point, start);
          this.vectorAt(arrow, index, fraction, vector);
          const length = vector.length() * this.scales[unit] * this.factor;
          // A short arrow is a small one: its head shrinks with it.
          const share = Math.min(1, length / (1.5 * heads * headLength));
          if (length > 0) turn.setFromUnitVectors(upwards, vector.normalize());
          size.set(share, Math.max(1e-9, length - share * headLength), share);
          shafts.setMatrixAt(i, matrix.compose(start, turn, size));
          for (let k = 0; k < heads; k++) {
            end.copy(start).addScaledVector(vector, length - 0.8 * k * share * headLength);
            cones.setMatrixAt(heads * i + k, matrix.compose(end, turn, size.set(share, share, share).addScalar(1e-9)));
          }
        });
        shafts.instanceMatrix.needsUpdate = cones.instanceMatrix.needsUpdate = true;
      }
    }
  };

  // The size that the largest arrow exceeds in few frames only: impacts would make all others dots.
  function usualSize(arrows, frames) {
    const largest = [];
    for (let k = 0; k < frames; k++) {
      let most = 0;
      for (const { vectors, scale } of arrows) {
        most = Math.max(most, scale * Math.hypot(vectors[3 * k], vectors[3 * k + 1], vectors[3 * k + 2]));
      }
      largest.push(most);
    }
    largest.sort((a, b) => a - b);
    return largest[Math.floor(usualShare * (frames - 1))] || largest[frames - 1] || 1;
  }

  // What the colors mean, and how long an arrow of a round number of newtons is.
  Gelenk.ArrowLegend = class {
    constructor(element, arrows, redraw) {
      Object.assign(this, { element, arrows });
      this.rows = arrows.groups.map(({ kind, unit, color }) => {
        const row = document.createElement("div");
        const bar = document.createElement("span");
        const text = document.createElement("span");
        bar.className = "scale-bar";
        bar.style.setProperty("--color", color);
        row.append(bar, text);
        element.append(row);
        return { unit, bar, text, name: kindNames[kind] };
      });
      const buttons = document.createElement("div");
      for (const [label, name, factor] of [["+", "Longer arrows", 1.5], ["\u2212", "Shorter arrows", 1 / 1.5]]) {
        const button = document.createElement("button");
        button.type = "button";
        button.textContent = label;
        button.title = name;
        button.setAttribute("aria-label", name);
        button.addEventListener("click", () => {
          arrows.factor *= factor;
          redraw();
        });
        buttons.append(button);
      }
      element.append(buttons);
    }

    update(orbit) {
      this.element.hidden = !this.arrows.visible;
      if (this.element.hidden) return;
      for (const { unit, bar, text, name } of this.rows) {
        const pixels = this.arrows.scales[unit] * this.arrows.factor / orbit.lengthOfPixel();
        const round = Gelenk.roundStep(45 / pixels, 1);
        const label = `${Number(round.toPrecision(1))} ${unit}: ${name}`;
        if (text.textContent !== label) text.textContent = label;
        bar.style.width = `${(round * pixels).toFixed(1)}px`;
      }
    }
  };

  // Axes of the frames of bodies and joints, fixed in the bodies.
  Gelenk.makeAxes = function (recording, model) {
    const groups = [];
    for (const body of [-1, ...recording.bodies.keys()]) {
      const own = recording.frameAxes.filter((frame) => frame.body === body);
      if (!own.length) continue;
      const group = new THREE.Group();
      axisColors.forEach((color, axis) => {
        const tubes = own.map((frame) => {
          const length = (frame.joint ? 0.1 : 0.16) * model.radius;
          const tip = frame.p.map((x, i) => x + length * frame.R[i][axis]);
          return { a: frame.p, b: tip, r: (frame.joint ? 0.006 : 0.008) * model.radius };
        });
        const geometry = Gelenk.solidGeometry({ tubes, balls: [], meshes: [] });
        group.add(new THREE.Mesh(geometry, model.material("solid", color)));
      });
      (body < 0 ? model.root : model.bodies[body]).add(group);
      groups.push(group);
    }
    return groups;
  };

  const upwards = new THREE.Vector3(0, 1, 0);
  const [start, end, vector, later, size] = Array.from({ length: 5 }, () => new THREE.Vector3());
  const turn = new THREE.Quaternion();
  const matrix = new THREE.Matrix4();
})();
