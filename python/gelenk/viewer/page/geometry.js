// SPDX-License-Identifier: BSD-3-Clause
// Merges the shapes of a body into one geometry: a body then costs one draw call.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  // Edges of meshes flatter than this angle look smooth, sharper ones stay edges.
  const creaseCosine = Math.cos(35 * Math.PI / 180);

  // A cylinder with flat ends along z from 0 to 1 with the radius 1.
  function unitTube(count) {
    const position = [];
    const normal = [];
    const index = [];
    for (let i = 0; i <= count; i++) {
      const angle = 2 * Math.PI * i / count;
      const x = Math.cos(angle);
      const y = Math.sin(angle);
      position.push(x, y, 0, x, y, 1);
      normal.push(x, y, 0, x, y, 0);
      if (i < count) {
        const k = 2 * i;
        index.push(k, k + 2, k + 1, k + 1, k + 2, k + 3);
      }
    }
    for (const end of [0, 1]) {
      const first = position.length / 3;
      for (let i = 0; i < count; i++) {
        const angle = 2 * Math.PI * i / count;
        position.push(Math.cos(angle), Math.sin(angle), end);
        normal.push(0, 0, 2 * end - 1);
        if (i > 1) index.push(first, first + i - 1 + (1 - end), first + i - (1 - end));
      }
    }
    return { position, normal, index };
  }

  function unitBall(around, down) {
    const position = [];
    const index = [];
    for (let j = 0; j <= down; j++) {
      const polar = Math.PI * j / down;
      for (let i = 0; i <= around; i++) {
        const angle = 2 * Math.PI * i / around;
        position.push(Math.sin(polar) * Math.cos(angle), Math.sin(polar) * Math.sin(angle), Math.cos(polar));
        if (i < around && j < down) {
          const k = j * (around + 1) + i;
          const below = k + around + 1;
          if (j > 0) index.push(k, below, k + 1);
          if (j < down - 1) index.push(k + 1, below, below + 1);
        }
      }
    }
    return { position, normal: position, index };
  }

  let tube;
  let wheel;
  let ball;

  // The more shapes there are, the smaller each is on the screen and the fewer facets show.
  Gelenk.setFineness = function (shapeCount) {
    tube = unitTube(shapeCount > 200 ? 8 : 12);
    wheel = unitTube(48);  // its corners would be seen
    ball = shapeCount > 200 ? unitBall(10, 6) : unitBall(16, 12);
  };

  function tubePart(shape) {
    const from = new THREE.Vector3(...shape.a);
    const along = new THREE.Vector3(...shape.b).sub(from);
    const length = along.length();
    if (!(length > 0)) return null;
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), along.divideScalar(length));
    const matrix = new THREE.Matrix4().compose(from, turn, new THREE.Vector3(shape.r, shape.r, length));
    return transformed(shape.r > 2 * length ? wheel : tube, matrix, turn);
  }

  function ballPart(shape) {
    const matrix = new THREE.Matrix4().makeScale(shape.r, shape.r, shape.r).setPosition(...shape.p);
    return transformed(ball, matrix, new THREE.Quaternion());
  }

  function transformed(template, matrix, turn) {
    const position = new Float32Array(template.position.length);
    const normal = new Float32Array(template.normal.length);
    const vector = new THREE.Vector3();
    for (let i = 0; i < position.length; i += 3) {
      vector.fromArray(template.position, i).applyMatrix4(matrix).toArray(position, i);
      vector.fromArray(template.normal, i).applyQuaternion(turn).toArray(normal, i);
    }
    return { position, normal, index: template.index };
  }

  // Numbers the distinct corners: files like STL repeat a corner in every triangle.
  function distinctCorners(vertices, triangles) {
    const numbers = new Map();
    return Uint32Array.from(triangles, (vertex) => {
      const key = vertices[3 * vertex] + "," + vertices[3 * vertex + 1] + "," + vertices[3 * vertex + 2];
      let number = numbers.get(key);
      if (number === undefined) numbers.set(key, number = numbers.size);
      return number;
    });
  }

  function faceNormals(vertices, triangles) {
    const normals = new Float32Array(triangles.length);
    const [a, b, c] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
    for (let i = 0; i < triangles.length; i += 3) {
      a.fromArray(vertices, 3 * triangles[i]);
      b.fromArray(vertices, 3 * triangles[i + 1]).sub(a);
      c.fromArray(vertices, 3 * triangles[i + 2]).sub(a);
      b.cross(c).normalize().toArray(normals, i);
    }
    return normals;
  }

  function meshPart(mesh) {
    const { vertices, triangles } = mesh;
    const faces = faceNormals(vertices, triangles);
    const corners = distinctCorners(vertices, triangles);
    const facesOfCorner = [];
    corners.forEach((corner, i) => {
      (facesOfCorner[corner] = facesOfCorner[corner] || []).push(3 * Math.floor(i / 3));
    });
    const position = new Float32Array(3 * triangles.length);
    const normal = new Float32Array(3 * triangles.length);
    const index = new Uint32Array(triangles.length);
    const own = new THREE.Vector3();
    const other = new THREE.Vector3();
    const sum = new THREE.Vector3();
    for (let i = 0; i < triangles.length; i++) {
      index[i] = i;
      for (let k = 0; k < 3; k++) position[3 * i + k] = vertices[3 * triangles[i] + k];
      own.fromArray(faces, 3 * Math.floor(i / 3));
      sum.set(0, 0, 0);
      for (const face of facesOfCorner[corners[i]]) {
        other.fromArray(faces, face);
        if (own.dot(other) > creaseCosine) sum.add(other);
      }
      if (sum.lengthSq() === 0) sum.copy(own);
      sum.normalize().toArray(normal, 3 * i);
    }
    return { position, normal, index };
  }

  // One geometry with all solid shapes of a body that have a role, or null without any.
  Gelenk.solidGeometry = function (shapes, role = "") {
    const own = (shape) => (shape.role || "") === role;
    const parts = [
      ...shapes.tubes.filter(own).map(tubePart), ...shapes.balls.filter(own).map(ballPart),
      ...shapes.meshes.filter(own).map(meshPart)
    ].filter((part) => part && part.index.length);
    if (!parts.length) return null;
    const total = (key) => parts.reduce((sum, part) => sum + part[key].length, 0);
    const position = new Float32Array(total("position"));
    const normal = new Float32Array(position.length);
    const index = new Uint32Array(total("index"));
    let vertex = 0;
    let corner = 0;
    for (const part of parts) {
      position.set(part.position, 3 * vertex);
      normal.set(part.normal, 3 * vertex);
      for (let i = 0; i < part.index.length; i++) index[corner++] = part.index[i] + vertex;
      vertex += part.position.length / 3;
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(position, 3));
    geometry.setAttribute("normal", new THREE.BufferAttribute(normal, 3));
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    return geometry;
  };

  // All polylines of a body as separate segments, or null without any.
  Gelenk.lineGeometry = function (lines) {
    const points = [];
    for (const line of lines) {
      for (let i = 1; i < line.length; i++) points.push(...line[i - 1], ...line[i]);
    }
    if (!points.length) return null;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
    return geometry;
  };

  // The center of the first shape: where a label or a test looks for the body.
  Gelenk.firstCenter = function (shapes) {
    const mean = (points) => {
      const box = new THREE.Box3();
      for (const point of points) box.expandByPoint(point);
      return box.isEmpty() ? new THREE.Vector3() : box.getCenter(new THREE.Vector3());
    };
    const vectors = (points) => points.map((point) => new THREE.Vector3(...point));
    if (shapes.tubes.length) return mean(vectors([shapes.tubes[0].a, shapes.tubes[0].b]));
    if (shapes.balls.length) return new THREE.Vector3(...shapes.balls[0].p);
    if (shapes.meshes.length) {
      return new THREE.Box3().setFromArray(shapes.meshes[0].vertices).getCenter(new THREE.Vector3());
    }
    return mean(vectors(shapes.lines[0] || []));
  };

  // The points of a body that reach farthest in 26 directions: they represent its outline.
  Gelenk.outlinePoints = function (geometries) {
    const directions = [];
    for (const x of [-1, 0, 1]) for (const y of [-1, 0, 1]) for (const z of [-1, 0, 1]) {
      if (x || y || z) directions.push([x, y, z, -Infinity, null]);
    }
    for (const geometry of geometries) {
      const array = geometry.attributes.position.array;
      for (let i = 0; i < array.length; i += 3) {
        for (const direction of directions) {
          const reach = direction[0] * array[i] + direction[1] * array[i + 1] + direction[2] * array[i + 2];
          if (reach > direction[3]) {
            direction[3] = reach;
            direction[4] = [array[i], array[i + 1], array[i + 2]];
          }
        }
      }
    }
    const distinct = new Map();
    for (const direction of directions) if (direction[4]) distinct.set(direction[4].join(), direction[4]);
    return distinct.size ? [...distinct.values()] : [[0, 0, 0]];
  };
})();
