// SPDX-License-Identifier: BSD-3-Clause
// The pointer that pulls a body by a spring.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  Gelenk.Pulling = class {
    constructor({ canvas, orbit, model, scene, computation, redraw }) {
      Object.assign(this, { canvas, orbit, model, computation, redraw });
      this.caster = new THREE.Raycaster();
      this.plane = new THREE.Plane();
      this.target = new THREE.Vector3();
      this.pointer = null;
      this.line = new THREE.Line(
        new THREE.BufferGeometry().setFromPoints([this.target, this.target]),
        new THREE.LineBasicMaterial({ color: 0xe8590c, depthTest: false })
      );
      this.line.renderOrder = 2;
      this.line.frustumCulled = false;
      this.line.visible = false;
      scene.add(this.line);
      canvas.addEventListener("pointerdown", (event) => this.press(event));
      canvas.addEventListener("pointermove", (event) => this.move(event));
      for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => this.release(event));
    }

    // Directs the ray through a pixel.
    aim(event) {
      const box = this.canvas.getBoundingClientRect();
      const x = 2 * (event.clientX - box.left) / box.width - 1;
      const y = 1 - 2 * (event.clientY - box.top) / box.height;
      this.caster.setFromCamera({ x, y }, this.orbit.camera);
    }

    // The body at a pixel, and the point of it that is seen there.
    find(event) {
      this.aim(event);
      const [hit] = this.caster.intersectObjects(this.model.bodies, true);
      if (!hit) return null;
      const body = this.model.bodies.find((group) => group === hit.object || group === hit.object.parent);
      return body && { body, point: hit.point };
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
      this.line.visible = this.pointer !== null;
      if (!this.line.visible) return;
      const positions = this.line.geometry.attributes.position;
      const from = this.body.localToWorld(this.own.clone());
      [from, this.target].forEach((point, i) => positions.setXYZ(i, point.x, point.y, point.z));
      positions.needsUpdate = true;
    }
  };
})();
