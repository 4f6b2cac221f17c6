// SPDX-License-Identifier: BSD-3-Clause
// What surrounds the mechanism: lights, the ground grid, and the triad of world axes.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  // Light falls from the sky and from over the viewer's shoulder: no view is left in the dark.
  Gelenk.addLights = function (scene, camera, up) {
    const sky = new THREE.HemisphereLight(0xffffff, 0x8c8c94, 0.62);
    sky.position.copy(up);
    const lamp = new THREE.DirectionalLight(0xffffff, 0.5);
    lamp.position.set(-0.5, 0.8, 1);
    camera.add(lamp, lamp.target);
    lamp.target.position.set(0, 0, -1);
    scene.add(sky, camera);
  };

  // A grid below everything the mechanism reaches, fading out with the distance.
  Gelenk.makeGrid = function (model, orbit) {
    const { right, away, up } = orbit;
    const reach = 3 * model.radius;
    const step = Gelenk.roundStep(2 * reach, 24);
    const count = Math.ceil(reach / step);
    let lowest = Infinity;
    const { cloud } = model;
    for (let i = 0; i < cloud.length; i += 3) {
      lowest = Math.min(lowest, up.x * cloud[i] + up.y * cloud[i + 1] + up.z * cloud[i + 2]);
    }
    const height = lowest - 0.01 * model.radius;
    const middle = [right, away].map((axis) => Math.round(model.center.dot(axis) / step) * step);
    const points = [];
    const colors = [];
    const addPoint = (i, j) => {
      const point = new THREE.Vector3().addScaledVector(up, height)
        .addScaledVector(right, middle[0] + i * step).addScaledVector(away, middle[1] + j * step);
      points.push(point.x, point.y, point.z);
      const alpha = Math.max(0, 1 - Math.hypot(i, j) / count);
      colors.push(1, 1, 1, alpha * Math.min(1, 0.35 + alpha));
    };
    for (let i = -count; i <= count; i++) {
      for (let j = -count; j < count; j++) {
        if (Math.min(Math.hypot(i, j), Math.hypot(i, j + 1)) >= count) continue;
        addPoint(i, j);
        addPoint(i, j + 1);
        addPoint(j, i);
        addPoint(j + 1, i);
      }
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
    geometry.setAttribute("color", new THREE.Float32BufferAttribute(colors, 4));
    const material = new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false });
    return new THREE.LineSegments(geometry, material);
  };

  // The triad is SVG: it stays sharp at any zoom and needs no second pass of the renderer.
  Gelenk.Triad = class {
    constructor(svg) {
      this.axes = ["x", "y", "z"].map((letter, i) => {
        const add = (kind) => {
          const element = document.createElementNS("http://www.w3.org/2000/svg", kind);
          element.setAttribute("class", "axis-" + letter);
          return element;
        };
        const group = document.createElementNS("http://www.w3.org/2000/svg", "g");
        const line = add("line");
        const text = add("text");
        text.textContent = letter;
        group.append(line, text);
        svg.append(group);
        const direction = new THREE.Vector3();
        direction.setComponent(i, 1);
        return { group, line, text, direction };
      });
      this.svg = svg;
    }

    update({ right, up, back }) {
      for (const axis of this.axes) {
        const x = axis.direction.dot(right);
        const y = -axis.direction.dot(up);
        axis.depth = axis.direction.dot(back);
        const length = Math.hypot(x, y);
        axis.line.setAttribute("x2", (25 * x).toFixed(2));
        axis.line.setAttribute("y2", (25 * y).toFixed(2));
        axis.text.setAttribute("x", (length > 1e-9 ? 25 * x + 8 * x / length : 0).toFixed(2));
        axis.text.setAttribute("y", (length > 1e-9 ? 25 * y + 8 * y / length : 0).toFixed(2));
        // An axis along the line of sight has no length on the screen, its letter would only blot.
        axis.group.style.visibility = length < 0.12 ? "hidden" : "visible";
      }
      const order = this.axes.slice().sort((a, b) => a.depth - b.depth);
      const key = order.map((axis) => axis.text.textContent).join("");
      if (key !== this.order) this.svg.append(...order.map((axis) => axis.group));
      this.order = key;
    }
  };
})();
