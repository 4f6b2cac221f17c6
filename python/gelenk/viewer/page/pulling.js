// SPDX-License-Identifier: BSD-3-Clause
// The pointer that pulls a body by a spring.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  // Pixels around the pointer at which a body is looked for, since links are thin and move; fingers are wider.
  const near = [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [0.7, 0.7], [-0.7, 0.7], [0.7, -0.7], [-0.7, -0.7]];
  const reach = { touch: 18, other: 9 };

  Gelenk.Pulling = class {
    constructor({ canvas, orbit, model, scene, computation, redraw }) {
      Object.assign(this, { canvas, orbit, model, computation, redraw });
      this.caster = new THREE.Raycaster();
      this.plane = new THREE.Plane();
      this.target = new THREE.Vector3();
      this.pointer = null;
      const material = new THREE.MeshBasicMaterial({ color: 0xe8590c, depthTest: false, transparent: true });
      this.line = new THREE.Mesh(new THREE.CylinderGeometry(1, 1, 1, 8).translate(0, 0.5, 0), material);
      this.end = new THREE.Mesh(new THREE.SphereGeometry(1, 16, 12), material);
      for (const part of [this.line, this.end]) {
        part.renderOrder = 2;
        part.visible = false;
        scene.add(part);
      }
      canvas.addEventListener("pointerdown", (event) => this.press(event));
      canvas.addEventListener("pointermove", (event) => this.move(event));
      for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => this.release(event));
    }

    // Directs the ray through a pixel, or one beside it.
    aim(event, dx = 0, dy = 0) {
      const box = this.canvas.getBoundingClientRect();
      const x = 2 * (event.clientX + dx - box.left) / box.width - 1;
      const y = 1 - 2 * (event.clientY + dy - box.top) / box.height;
      this.caster.setFromCamera({ x, y }, this.orbit.camera);
    }

    // The body at a pixel or near it, and the point of it that is seen there.
    find(event) {
      const pixels = reach[event.pointerType] || reach.other;
      for (const [x, y] of near) {
        this.aim(event, pixels * x, pixels * y);
        const [hit] = this.caster.intersectObjects(this.model.bodies, true);
        const body = hit && this.model.bodies.find((group) => group === hit.object || group === hit.object.parent);
        if (body) return { body, point: hit.point };
      }
      return null;
    }

    press(event) {
      if (this.pointer !== null || event.button !== 0 || event.shiftKey) return;
      const found = this.find(event);
      if (!found) return;
      event.stopImmediatePropagation();
      this.canvas.setPointerCapture(event.pointerId);
      this.pointer = event.pointerId;
      this.body = found.body;
      this.own = found.body.worldToLocal(found.point.clone());
      this.plane.setFromNormalAndCoplanarPoint(this.orbit.axes.back, found.point);
      this.target.copy(found.point);
      this.send();
    }

    move(event) {
      if (event.pointerId !== this.pointer) {
        if (!event.buttons) this.canvas.classList.toggle("pulls", Boolean(this.find(event)));
        return;
      }
      event.stopImmediatePropagation();
      this.aim(event);
      if (this.caster.ray.intersectPlane(this.plane, this.target)) this.send();
    }

    send() {
      this.computation.pull(this.body.name, this.own.toArray(), this.target.toArray());
      this.redraw();
    }

    release(event) {
      if (event.pointerId !== this.pointer) return;
      event.stopImmediatePropagation();
      this.pointer = null;
      this.computation.letGo();
      this.redraw();
    }

    // Draws the spring, from the point of the body to the pointer.
    update() {
      const pulls = this.pointer !== null;
      this.line.visible = this.end.visible = pulls;
      if (!pulls) return;
      const pixel = this.orbit.lengthOfPixel();
      const from = this.body.localToWorld(this.own.clone());
      const along = this.target.clone().sub(from);
      const length = along.length();
      this.line.position.copy(from);
      if (length > 0) this.line.quaternion.setFromUnitVectors(axis, along.divideScalar(length));
      this.line.scale.set(1.5 * pixel, Math.max(length, pixel), 1.5 * pixel);
      this.end.position.copy(this.target);
      this.end.scale.setScalar(5 * pixel);
    }
  };

  const axis = new THREE.Vector3(0, 1, 0);  // of the cylinder
})();
