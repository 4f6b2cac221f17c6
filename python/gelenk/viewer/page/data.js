// SPDX-License-Identifier: BSD-3-Clause
// Reads the recording that Python wrote into the page and searches it by time.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  // Typed arrays use the byte order of the machine, and every platform with a
  // browser is little endian as the data are.
  function decode(text, ArrayType) {
    const characters = atob(text || "");
    const bytes = new Uint8Array(characters.length);
    for (let i = 0; i < bytes.length; i++) bytes[i] = characters.charCodeAt(i);
    return new ArrayType(bytes.buffer);
  }

  Gelenk.decode = decode;

  function readShapes(shapes) {
    return {
      name: shapes.name || "",
      color: shapes.color || "#8a8f98",
      tubes: shapes.tubes || [],
      balls: shapes.balls || [],
      lines: shapes.lines || [],
      meshes: (shapes.meshes || []).map((mesh) => ({
        vertices: decode(mesh.vertices, Float32Array),
        triangles: decode(mesh.triangles, Uint32Array)
      }))
    };
  }

  Gelenk.readRecording = function (text) {
    const raw = JSON.parse(text);
    const time = decode(raw.time, Float64Array);
    return {
      name: raw.name || "Mechanism",
      version: raw.version || "",
      up: raw.up || [0, 0, 1],
      towards: raw.towards || [0.5, -0.8, 0.45],
      flat: Boolean(raw.flat),
      time: time.length ? time : new Float64Array(1),
      frames: Math.max(1, time.length),
      bodies: (raw.bodies || []).map(readShapes),
      ground: readShapes(raw.ground || {}),
      poses: decode(raw.poses, Float32Array),
      second: raw.second ? {
        name: raw.second.name,
        bodies: (raw.second.bodies || []).map(readShapes),
        ground: readShapes(raw.second.ground || {}),
        poses: decode(raw.second.poses, Float32Array),
        springs: raw.second.springs || [],
        frames: Math.max(1, time.length),
        colors: raw.colors || {}
      } : null,
      modes: (raw.modes || []).map((mode) => ({
        ...mode, time: decode(mode.time, Float64Array), poses: decode(mode.poses, Float32Array)
      })),
      joints: raw.joints || [],
      springs: raw.springs || [],
      signals: (raw.signals || []).map((signal) => ({
        name: signal.name,
        unit: signal.unit || "",
        values: decode(signal.values, Float32Array),
        second: signal.second ? decode(signal.second, Float32Array) : null
      })),
      shown: raw.shown || [],
      arrows: (raw.arrows || []).map((arrow) => ({
        ...arrow,
        points: arrow.points ? decode(arrow.points, Float32Array) : null,
        vectors: decode(arrow.vectors, Int16Array)
      })),
      frameAxes: raw.frames || [],
      colors: raw.colors || {},
      live: Boolean(raw.live),
      reach: raw.reach ? decode(raw.reach, Float32Array) : null,
      computes: raw.computes || null,
      events: (raw.events || []).slice().sort((a, b) => a.t - b.t)
    };
  };

  // Index of the last sample at or before t; the first one if t is earlier.
  Gelenk.indexBefore = function (time, t) {
    let low = 0;
    let high = time.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (time[middle] <= t) low = middle;
      else high = middle - 1;
    }
    return low;
  };

  Gelenk.nearestIndex = function (time, t) {
    const before = Gelenk.indexBefore(time, t);
    const after = Math.min(before + 1, time.length - 1);
    return time[after] - t < t - time[before] ? after : before;
  };

  // Position between the samples: the index before t and the fraction of the way to the next.
  Gelenk.locate = function (time, t) {
    const index = Gelenk.indexBefore(time, t);
    if (index >= time.length - 1 || t <= time[index]) return { index, fraction: 0 };
    return { index, fraction: (t - time[index]) / (time[index + 1] - time[index]) };
  };

  // Round step widths 1, 2, 5 times a power of ten, so that about `count` of them fill `span`.
  Gelenk.roundStep = function (span, count) {
    const rough = span / Math.max(1, count);
    const power = Math.pow(10, Math.floor(Math.log10(rough)));
    const digit = rough / power;
    return power * (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10);
  };
})();
