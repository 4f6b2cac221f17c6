// SPDX-License-Identifier: BSD-3-Clause
// Names of joints and bodies as HTML over the canvas, so that they grow with the browser's zoom.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  const gap = 2;
  const mostBoxes = 60;

  Gelenk.Labels = class {
    constructor(container, recording, model) {
      this.container = container;
      this.model = model;
      this.items = [];
      for (const joint of recording.joints) {
        this.add(joint.name, "joint" + (joint.driven ? " driven" : ""), joint.body, joint.p, 10);
      }
      recording.bodies.forEach((shapes, b) => {
        if (shapes.name) this.add(shapes.name, "body", b, model.bodies[b].userData.center.toArray(), 0);
      });
      // Boxes around many labels take longer to draw than the mechanism.
      container.classList.toggle("many", this.items.length > mostBoxes);
      this.setVisible(recording.joints.length <= 12);
    }

    // `lift` pixels keep the label of a joint beside the joint instead of on it.
    add(text, kind, body, point, lift) {
      const element = document.createElement("div");
      element.className = "label " + kind;
      element.textContent = text;
      this.container.append(element);
      this.items.push({ element, body, point, lift, x: 0, y: 0 });
    }

    setVisible(visible) {
      this.visible = visible;
      this.container.hidden = !visible;
    }

    update(orbit) {
      if (!this.visible) return;
      const vector = new THREE.Vector3();
      const seen = [];
      for (const item of this.items) {
        // The size changes with the browser's zoom, which also resizes the window.
        if (item.measured !== orbit.width) {
          item.width = item.element.offsetWidth;
          item.height = item.element.offsetHeight;
          item.measured = orbit.width;
        }
        const pixel = orbit.project(this.model.worldPoint(item.body, item.point, vector), vector);
        let inside = pixel && pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] <= orbit.width && pixel[1] <= orbit.height;
        if (inside) {
          item.x = pixel[0] + (item.lift ? item.lift : -item.width / 2);
          // At the right edge, the label of a joint is on the other side of it.
          if (item.lift && item.x + item.width > orbit.width) item.x = pixel[0] - item.lift - item.width;
          item.x = Math.max(0, Math.min(item.x, orbit.width - item.width));
          item.y = Math.max(0, Math.min(pixel[1] - item.lift - item.height / 2, orbit.height - item.height));
          inside = this.makeRoom(item, seen) && item.y + item.height <= orbit.height;
        }
        if (item.inside !== Boolean(inside)) item.element.style.visibility = inside ? "visible" : "hidden";
        item.inside = Boolean(inside);
        if (!inside) continue;
        item.element.style.transform = `translate(${item.x.toFixed(1)}px, ${item.y.toFixed(1)}px)`;
        seen.push(item);
      }
    }

    // Pushes a label down until it covers none of the earlier ones. One that would end up far
    // from its place is left out instead: zooming in makes room for it.
    makeRoom(item, seen) {
      for (let tries = 0; tries < 4; tries++) {
        const other = seen.find((o) => item.x < o.x + o.width + gap && o.x < item.x + item.width + gap
          && item.y < o.y + o.height + gap && o.y < item.y + item.height + gap);
        if (!other) return true;
        item.y = other.y + other.height + gap;
      }
      return false;
    }
  };
})();
