// SPDX-License-Identifier: BSD-3-Clause
// A camera on a sphere around its target whose picture always has the world's up on top.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  const halfAngle = 15 * Math.PI / 180;
  const margin = 1.08;
  const followingMargin = 1.3;  // bodies turn while the camera follows

  Gelenk.OrbitCamera = class {
    constructor(recording, model) {
      this.model = model;
      this.flat = recording.flat;
      this.camera = this.flat
        ? new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 1)
        : new THREE.PerspectiveCamera(2 * halfAngle * 180 / Math.PI, 1, 0.1, 10);
      this.up = new THREE.Vector3(...recording.up).normalize();
      // Horizontal directions: the first is right in the front view, the second points away.
      this.right = new THREE.Vector3(1, 0, 0);
      if (Math.abs(this.up.x) > 0.9) this.right.set(0, 1, 0);
      this.right.addScaledVector(this.up, -this.right.dot(this.up)).normalize();
      this.away = new THREE.Vector3().crossVectors(this.up, this.right);
      this.start = this.anglesOf(new THREE.Vector3(...recording.towards));
      this.target = model.center.clone();
      this.distance = 1;
      this.width = this.height = 1;
      this.inset = 0;
      this.axes = { right: new THREE.Vector3(), up: new THREE.Vector3(), back: new THREE.Vector3() };
      Object.assign(this, this.start);
      this.untouched = true;
      this.following = false;
      this.followed = new THREE.Vector3();
    }

    // Keeps the bodies at rest in the picture, and the world moving, or the other way round.
    setFollowing(on) {
      this.following = on;
      this.model.middle(this.followed);
      this.fit();
      this.untouched = true;
    }

    // Call after the bodies have moved.
    follow() {
      if (!this.following) return;
      const before = this.followed.clone();
      this.target.add(this.model.middle(this.followed)).sub(before);
      this.apply();
    }

    // Angles instead of vectors keep the view well defined even straight from above.
    anglesOf(direction) {
      if (!(direction.length() > 0)) direction.copy(this.away).negate();
      direction.normalize();
      const x = direction.dot(this.right);
      const y = direction.dot(this.away);
      const azimuth = Math.hypot(x, y) < 1e-6 ? -Math.PI / 2 : Math.atan2(y, x);
      return { azimuth, elevation: Math.asin(Math.min(1, Math.max(-1, direction.dot(this.up)))) };
    }

    // `inset` pixels at the top are covered by the buttons; fitting keeps out of them.
    resize(width, height, inset) {
      this.width = Math.max(1, width);
      this.height = Math.max(1, height);
      this.inset = Math.min(inset, this.height / 3);
      if (this.untouched) this.fit();
      else this.apply();
    }

    setView(name) {
      const quarter = Math.PI / 2;
      const views = {
        front: { azimuth: -quarter, elevation: 0 },
        side: { azimuth: 0, elevation: 0 },
        top: { azimuth: -quarter, elevation: quarter },
        start: this.start,
        fit: {}
      };
      if (!Object.prototype.hasOwnProperty.call(views, name)) return false;
      Object.assign(this, views[name]);
      this.fit();
      this.untouched = true;
      return true;
    }

    updateAxes() {
      const { right, up, back } = this.axes;
      const [c, s] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
      right.copy(this.right).multiplyScalar(-s).addScaledVector(this.away, c);
      back.copy(this.right).multiplyScalar(c).addScaledVector(this.away, s)
        .multiplyScalar(Math.cos(this.elevation)).addScaledVector(this.up, Math.sin(this.elevation));
      up.crossVectors(back, right);
    }

    // Moves target and distance so that all points of the run just fill the free part of the window.
    fit() {
      this.updateAxes();
      const { right, up, back } = this.axes;
      const { cloud, center, radius } = this.following ? this.model.measureBodies() : this.model;
      const spare = this.following ? followingMargin : margin;
      const tangent = Math.tan(halfAngle);
      const free = this.height - this.inset;
      const tangentY = tangent * free / this.height / spare;
      const tangentX = tangent * this.width / this.height / spare;
      const depth = this.flat ? 0 : 1;
      const count = cloud.length / 3;
      const local = new Float32Array(cloud.length);
      for (let i = 0; i < count; i++) {
        const x = cloud[3 * i] - center.x;
        const y = cloud[3 * i + 1] - center.y;
        const z = cloud[3 * i + 2] - center.z;
        local[3 * i] = right.x * x + right.y * y + right.z * z;
        local[3 * i + 1] = up.x * x + up.y * y + up.z * z;
        local[3 * i + 2] = depth * (back.x * x + back.y * y + back.z * z);
      }
      let x = 0;
      let y = 0;
      let distance = 0;
      // Perspective shifts the middle of the picture with the distance, so it takes a few rounds.
      for (let round = 0; round < 4; round++) {
        distance = 0.05 * radius;
        for (let i = 0; i < local.length; i += 3) {
          const width = Math.abs(local[i] - x) / tangentX;
          const height = Math.abs(local[i + 1] - y) / tangentY;
          distance = Math.max(distance, local[i + 2] + Math.max(width, height));
        }
        if (round === 3) break;
        let [left, rightmost, bottom, top] = [Infinity, -Infinity, Infinity, -Infinity];
        for (let i = 0; i < local.length; i += 3) {
          const scale = distance / Math.max(1e-3 * distance, distance - local[i + 2]);
          left = Math.min(left, (local[i] - x) * scale);
          rightmost = Math.max(rightmost, (local[i] - x) * scale);
          bottom = Math.min(bottom, (local[i + 1] - y) * scale);
          top = Math.max(top, (local[i + 1] - y) * scale);
        }
        x += (left + rightmost) / 2;
        y += (bottom + top) / 2;
      }
      this.distance = distance;
      y += this.inset / 2 * this.lengthOfPixel();
      this.target.copy(center).addScaledVector(right, x).addScaledVector(up, y);
      this.apply();
    }

    // World length of a CSS pixel at the distance of the target.
    lengthOfPixel() {
      return 2 * this.distance * Math.tan(halfAngle) / this.height;
    }

    apply() {
      this.updateAxes();
      const { camera, axes, distance } = this;
      const { center, radius } = this.model;
      camera.position.copy(this.target).addScaledVector(axes.back, distance);
      camera.quaternion.setFromRotationMatrix(new THREE.Matrix4().makeBasis(axes.right, axes.up, axes.back));
      const reach = camera.position.distanceTo(center) + 8 * radius;
      if (this.flat) {
        const half = distance * Math.tan(halfAngle);
        camera.top = half;
        camera.bottom = -half;
        camera.right = half * this.width / this.height;
        camera.left = -camera.right;
        camera.near = -reach;
      } else {
        camera.aspect = this.width / this.height;
        camera.near = Math.max(0.02 * distance, camera.position.distanceTo(center) - 8 * radius);
      }
      camera.far = reach;
      camera.updateProjectionMatrix();
      camera.updateMatrixWorld();
    }

    rotate(dx, dy) {
      const turn = Math.PI / Math.min(this.width, this.height);
      this.azimuth -= dx * turn;
      this.elevation = Math.min(Math.PI / 2, Math.max(-Math.PI / 2, this.elevation + dy * turn));
      this.moved();
    }

    pan(dx, dy) {
      const length = this.lengthOfPixel();
      this.target.addScaledVector(this.axes.right, -dx * length).addScaledVector(this.axes.up, dy * length);
      this.moved();
    }

    // Zooms such that the point under the pointer, x and y from the middle, stays in place.
    zoom(factor, x, y) {
      const before = this.distance;
      const { radius } = this.model;
      this.distance = Math.min(60 * radius, Math.max(1e-3 * radius, before * factor));
      const shift = (this.lengthOfPixel() / this.distance) * (before - this.distance);
      this.target.addScaledVector(this.axes.right, x * shift).addScaledVector(this.axes.up, -y * shift);
      this.moved();
    }

    moved() {
      this.untouched = false;
      this.apply();
    }

    // CSS pixel of a world point in the canvas, or null behind the camera.
    project(point, target) {
      target.copy(point).project(this.camera);
      if (target.z > 1 || target.z < -1) return null;
      return [(target.x + 1) / 2 * this.width, (1 - target.y) / 2 * this.height];
    }
  };

  // Mouse, pen, and fingers on the canvas.
  Gelenk.attachPointers = function (canvas, orbit, changed) {
    const pointers = new Map();
    const spread = () => {
      const [a, b] = [...pointers.values()];
      return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, size: Math.hypot(a.x - b.x, a.y - b.y) };
    };
    const middle = () => {
      const box = canvas.getBoundingClientRect();
      return { x: box.left + box.width / 2, y: box.top + box.height / 2 };
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, pan: event.button !== 0 || event.shiftKey });
      canvas.classList.add("dragging");
    });
    canvas.addEventListener("pointermove", (event) => {
      const pointer = pointers.get(event.pointerId);
      if (!pointer) return;
      const before = pointers.size === 2 ? spread() : null;
      const [dx, dy] = [event.clientX - pointer.x, event.clientY - pointer.y];
      pointer.x = event.clientX;
      pointer.y = event.clientY;
      if (before) {
        const after = spread();
        orbit.pan(after.x - before.x, after.y - before.y);
        const center = middle();
        if (after.size > 0) orbit.zoom(before.size / after.size, after.x - center.x, after.y - center.y);
      } else if (pointers.size === 1) {
        if (pointer.pan) orbit.pan(dx, dy);
        else orbit.rotate(dx, dy);
      }
      changed();
    });
    const release = (event) => {
      pointers.delete(event.pointerId);
      if (!pointers.size) canvas.classList.remove("dragging");
    };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 16 : event.deltaMode === 2 ? 400 : 1;
      const amount = Math.max(-300, Math.min(300, event.deltaY * lines));
      const center = middle();
      orbit.zoom(Math.exp(0.0015 * amount), event.clientX - center.x, event.clientY - center.y);
      changed();
    }, { passive: false });
  };
})();
