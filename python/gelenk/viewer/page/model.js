// SPDX-License-Identifier: BSD-3-Clause
// The mechanism as three.js objects, placed by the poses of the recording.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  // More sampled poses than this would delay the first picture noticeably.
  const sampledPoses = 20000;

  // Relative luminance and contrast ratio as WCAG defines them.
  function luminance(color) {
    const linear = (c) => (c <= 0.04045 ? c / 12.92 : Math.pow((c + 0.055) / 1.055, 2.4));
    return 0.2126 * linear(color.r) + 0.7152 * linear(color.g) + 0.0722 * linear(color.b);
  }

  // Moves the lightness of a color away from the background until both can be distinguished.
  Gelenk.readableColor = function (name, background) {
    const color = new THREE.Color(name);
    const behind = luminance(background);
    const hsl = color.getHSL({});
    for (let step = 0; step < 20; step++) {
      const own = luminance(color);
      if ((Math.max(own, behind) + 0.05) / (Math.min(own, behind) + 0.05) >= 2.4) break;
      hsl.l = behind < 0.2 ? Math.min(1, hsl.l + 0.04) : Math.max(0, hsl.l - 0.04);
      color.setHSL(hsl.h, hsl.s, hsl.l);
    }
    return color;
  };

  // The model of a recording. Of one that is computed, it knows what an earlier run has reached.
  Gelenk.reachingModel = function (recording) {
    const { poses, frames, reach, bodies } = recording;
    if (!reach) return new Gelenk.Model(recording);
    Object.assign(recording, { poses: reach, frames: reach.length / (7 * bodies.length) || 1 });
    const model = new Gelenk.Model(recording);
    Object.assign(recording, { poses, frames });
    model.setFrame(0, 0);
    return model;
  };

  Gelenk.Model = class {
    // With an opacity below 1, what is behind shows through.
    constructor(recording, opacity = 1) {
      this.recording = recording;
      this.opacity = opacity;
      this.root = new THREE.Group();
      this.materials = new Map();
      this.geometries = new Map();
      Gelenk.setFineness(recording.bodies.reduce((sum, { tubes, balls }) => sum + tubes.length + balls.length, 0));
      this.ground = this.makeBody(recording.ground);
      this.bodies = recording.bodies.map((shapes) => this.makeBody(shapes));
      this.measure();
      this.springs = recording.springs.map((spring) => this.makeSpring(spring));
      this.setFrame(0, 0);
    }

    makeBody(shapes) {
      const group = new THREE.Group();
      group.name = shapes.name;
      const { solid, symbols, wire, outline } = this.geometryOf(shapes);
      const side = shapes.meshes.length ? "two-sided" : "solid";
      if (solid) group.add(new THREE.Mesh(solid, this.material(side, shapes.color)));
      for (const [role, symbol] of symbols) {
        group.add(new THREE.Mesh(symbol, this.material("solid", this.recording.colors[role] || shapes.color)));
      }
      if (wire) group.add(new THREE.LineSegments(wire, this.material("line", shapes.color)));
      group.userData = { shapes, outline, center: Gelenk.firstCenter(shapes) };
      this.root.add(group);
      return group;
    }

    // Bodies of the same shape, such as the links of a chain, share one geometry.
    geometryOf(shapes) {
      const key = shapes.meshes.length ? shapes : JSON.stringify([shapes.tubes, shapes.balls, shapes.lines]);
      if (!this.geometries.has(key)) {
        const solid = Gelenk.solidGeometry(shapes);
        const symbols = ["joint", "loop"].map((role) => [role, Gelenk.solidGeometry(shapes, role)])
          .filter(([, symbol]) => symbol);
        const wire = Gelenk.lineGeometry(shapes.lines);
        const all = [solid, wire, ...symbols.map(([, symbol]) => symbol)].filter(Boolean);
        this.geometries.set(key, { solid, symbols, wire, outline: Gelenk.outlinePoints(all) });
      }
      return this.geometries.get(key);
    }

    material(kind, color) {
      const key = kind + color;
      if (!this.materials.has(key)) {
        const material = kind === "line"
          ? new THREE.LineBasicMaterial()
          : new THREE.MeshLambertMaterial({ side: kind === "two-sided" ? THREE.DoubleSide : THREE.FrontSide });
        if (kind === "seen through") material.depthTest = false;
        material.userData.color = color;
        if (this.opacity < 1) Object.assign(material, { transparent: true, opacity: this.opacity });
        if (this.background) material.color.copy(Gelenk.readableColor(color, this.background));
        this.materials.set(key, material);
      }
      return this.materials.get(key);
    }

    setTheme(background) {
      this.background = background;
      for (const material of this.materials.values()) {
        material.color.copy(Gelenk.readableColor(material.userData.color, background));
      }
    }

    // Points that the mechanism reaches during the run, their box, and the radius of both.
    measure() {
      const { frames, bodies } = this.recording;
      const stride = Math.max(1, Math.ceil(frames * bodies.length / sampledPoses));
      const points = this.ground.children.length ? this.ground.userData.outline.flat() : [];
      const matrix = new THREE.Matrix4();
      const vector = new THREE.Vector3();
      for (let k = 0; k < frames; k = k === frames - 1 ? frames : Math.min(k + stride, frames - 1)) {
        this.bodies.forEach((body, b) => {
          this.placeAt(body, b, k, 0);
          matrix.compose(body.position, body.quaternion, body.scale);
          for (const point of body.userData.outline) {
            vector.set(point[0], point[1], point[2]).applyMatrix4(matrix);
            if (Number.isFinite(vector.x + vector.y + vector.z)) points.push(vector.x, vector.y, vector.z);
          }
        });
      }
      for (const spring of this.recording.springs) {
        for (const end of [spring.from, spring.to]) if (end.body < 0) points.push(...end.p);
      }
      if (!points.length) points.push(0, 0, 0);
      this.cloud = Float32Array.from(points);
      this.box = new THREE.Box3().setFromArray(this.cloud);
      this.center = this.box.getCenter(new THREE.Vector3());
      this.radius = this.box.getSize(vector).length() / 2 || 1;
    }

    // Lets the camera see what another mechanism reaches, too.
    include(other) {
      const cloud = new Float32Array(this.cloud.length + other.cloud.length);
      cloud.set(this.cloud);
      cloud.set(other.cloud, this.cloud.length);
      this.cloud = cloud;
      this.box.union(other.box);
      this.box.getCenter(this.center);
      this.radius = this.box.getSize(nextPosition).length() / 2 || 1;
    }

    // The same of the bodies alone, where they are now.
    measureBodies() {
      const vector = new THREE.Vector3();
      const points = this.bodies.flatMap((body) => body.userData.outline.flatMap(
        (point) => vector.set(point[0], point[1], point[2]).applyMatrix4(body.matrixWorld).toArray()
      ));
      if (!points.length) return this;
      const box = new THREE.Box3().setFromArray(points);
      return {
        cloud: Float32Array.from(points),
        center: box.getCenter(new THREE.Vector3()),
        radius: box.getSize(vector).length() / 2 || this.radius
      };
    }

    // What a camera that follows looks at: the middle of the frames of the bodies.
    middle(target) {
      target.set(0, 0, 0);
      for (const body of this.bodies) target.add(body.position);
      return target.divideScalar(Math.max(1, this.bodies.length));
    }

    placeAt(group, b, index, fraction) {
      const { poses, bodies, frames } = this.recording;
      const at = 7 * (index * bodies.length + b);
      if (at + 7 > poses.length) return;
      group.position.fromArray(poses, at);
      group.quaternion.fromArray(poses, at + 3);
      if (fraction > 0 && index + 1 < frames) {
        const next = at + 7 * bodies.length;
        group.position.lerp(nextPosition.fromArray(poses, next), fraction);
        group.quaternion.slerp(nextQuaternion.fromArray(poses, next + 3), fraction);
      }
    }

    setFrame(index, fraction) {
      this.bodies.forEach((body, b) => this.placeAt(body, b, index, fraction));
      this.root.updateMatrixWorld();
      this.springs.forEach((spring) => this.placeSpring(spring));
    }

    // World position of a point given in the frame of a body; -1 is the world.
    worldPoint(body, point, target) {
      target.set(point[0], point[1], point[2]);
      return body < 0 || !this.bodies[body] ? target : target.applyMatrix4(this.bodies[body].matrixWorld);
    }

    body(name) {
      return this.bodies.find((body) => body.name === name) || null;
    }

    makeSpring(spring) {
      const from = this.worldPoint(spring.from.body, spring.from.p, new THREE.Vector3());
      const to = this.worldPoint(spring.to.body, spring.to.p, new THREE.Vector3());
      const length = Math.max(from.distanceTo(to), 0.05 * this.radius);
      const radius = Math.min(0.035 * this.radius, 0.12 * length);
      // A coil is made of triangles when there are few; a fine line must do for nets of springs.
      const fine = this.recording.springs.length > 40;
      const coil = new Coil(radius / length);
      const geometry = fine
        ? new THREE.BufferGeometry().setFromPoints(coil.getPoints(160))
        : new THREE.TubeGeometry(coil, 150, 0.16 * radius / length, 5);
      const object = fine
        ? new THREE.Line(geometry, this.material("line", "#7d8590"))
        : new THREE.Mesh(geometry, this.material("solid", "#7d8590"));
      object.userData = { spring, length };
      this.root.add(object);
      return object;
    }

    // Lengthens the coil along its axis only, so that its radius stays as it is.
    placeSpring(object) {
      const { spring, length } = object.userData;
      this.worldPoint(spring.from.body, spring.from.p, object.position);
      this.worldPoint(spring.to.body, spring.to.p, nextPosition).sub(object.position);
      const distance = nextPosition.length();
      object.visible = distance > 1e-6 * length;
      if (!object.visible) return;
      object.quaternion.setFromUnitVectors(coilAxis, nextPosition.divideScalar(distance));
      object.scale.set(distance, length, length);
      object.updateMatrixWorld();
    }

    // Paths of the frame origin and of the farthest point of each body; built when first shown.
    showTrails(visible) {
      if (visible && !this.trails) {
        this.trails = new THREE.Group();
        this.bodies.forEach((body, b) => {
          const distance = (point) => Math.hypot(...point);
          const farthest = body.userData.outline.reduce((a, c) => (distance(c) > distance(a) ? c : a));
          const points = distance(farthest) > 1e-6 * this.radius ? [[0, 0, 0], farthest] : [[0, 0, 0]];
          for (const point of points) this.addTrail(body, b, point);
        });
        this.root.add(this.trails);
      }
      if (this.trails) this.trails.visible = visible;
    }

    addTrail(body, b, point) {
      const { frames } = this.recording;
      // Points that lie closer together than can be seen would only slow the drawing down.
      const apart = this.radius / 300;
      const path = [];
      const ghost = new THREE.Object3D();
      for (let k = 0; k < frames; k++) {
        this.placeAt(ghost, b, k, 0);
        const vector = new THREE.Vector3(...point).applyQuaternion(ghost.quaternion).add(ghost.position);
        if (!Number.isFinite(vector.x + vector.y + vector.z)) continue;
        if (!path.length || k === frames - 1 || vector.distanceTo(path[path.length - 1]) >= apart) path.push(vector);
      }
      if (path.length < 2 || new THREE.Box3().setFromPoints(path).getSize(nextPosition).length() < 1e-4 * this.radius) return;
      const geometry = new THREE.BufferGeometry().setFromPoints(path);
      this.trails.add(new THREE.Line(geometry, this.material("line", body.userData.shapes.color)));
    }
  };

  const nextPosition = new THREE.Vector3();
  const nextQuaternion = new THREE.Quaternion();
  const coilAxis = new THREE.Vector3(1, 0, 0);

  // A coil along x from 0 to 1 with straight ends on the axis.
  class Coil extends THREE.Curve {
    constructor(radius) {
      super();
      this.radius = radius;
    }

    getPoint(t, target = new THREE.Vector3()) {
      const inside = Math.min(1, Math.max(0, (t - 0.1) / 0.8));
      const opening = Math.min(1, 12 * inside, 12 * (1 - inside));
      const angle = 2 * Math.PI * 9 * inside;
      return target.set(t, this.radius * opening * Math.cos(angle), this.radius * opening * Math.sin(angle));
    }
  }
})();
