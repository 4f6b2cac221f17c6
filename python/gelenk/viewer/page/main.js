// SPDX-License-Identifier: BSD-3-Clause
// Puts the parts together once the whole page is read; the order of the files does not matter.
(function () {
  "use strict";
  const Gelenk = window.Gelenk = window.Gelenk || {};

  const translucent = 0.35;
  const farAway = 4;  // size of the run, in sizes of the mechanism, from which the camera follows

  const element = (id) => document.getElementById(id);

  function readColors() {
    const style = getComputedStyle(document.documentElement);
    const names = ["back", "grid", "edge", "text", "faint", "line", "second", "cursor"];
    return Object.fromEntries(names.map((name) => [name, style.getPropertyValue("--" + name).trim()]));
  }

  function start() {
    const recording = Gelenk.readRecording(element("data").textContent);
    const canvas = element("canvas");
    const model = Gelenk.reachingModel(recording);
    const second = recording.second && new Gelenk.Model(recording.second, translucent);
    if (second) model.include(second);
    const orbit = new Gelenk.OrbitCamera(recording, model);
    const scene = new THREE.Scene();
    const grid = recording.flat ? null : Gelenk.makeGrid(model, orbit);
    let request = 0;
    const redraw = () => { if (!request) request = requestAnimationFrame(draw); };
    const picture = new Gelenk.Picture(canvas, redraw);
    const triad = new Gelenk.Triad(element("triad"));
    scene.add(model.root);
    if (second) scene.add(second.root);
    if (grid) scene.add(grid);
    Gelenk.addLights(scene, orbit.camera, orbit.up);
    const title = second ? `${recording.name}, translucent: ${recording.second.name}` : recording.name;
    element("name").textContent = title;
    element("name").title = title;
    element("missing").hidden = picture.available;
    canvas.hidden = !picture.available;
    element("triad").style.display = picture.available ? "" : "none";

    for (const mode of recording.modes) {
      recording.poses = mode.poses;
      const reached = new Gelenk.Model(recording);
      model.include(reached);
    }
    if (recording.modes.length) recording.poses = recording.modes[0].poses;

    const drawn = [];
    const arrows = new Gelenk.Arrows(recording, model);
    const legend = new Gelenk.ArrowLegend(element("legend"), arrows, redraw);
    let axes = null;
    const bar = { update() {}, showEvent() {} };
    const player = new Gelenk.Player(recording, redraw, (event) => bar.showEvent(event));
    const labels = new Gelenk.Labels(element("labels"), recording, model);
    const panel = new Gelenk.Panel(recording, player, redraw);
    const playerBar = new Gelenk.PlayerBar(recording, player);
    const modeBar = new Gelenk.ModeBar(recording, () => {
      player.measure();
      playerBar.measure();
      redraw();
    });
    const live = recording.live && new Gelenk.Live(recording, player, playerBar, panel, redraw, () => {
      const { cloud } = model.measureBodies();
      const box = new THREE.Box3().setFromArray(cloud);
      if (model.box.containsBox(box)) return;
      model.include({ cloud, box });
      if (orbit.untouched) orbit.fit();
    });
    const computation = recording.computes && new Gelenk.Computation({ recording, player, live, panel, redraw });
    const pulling = computation && new Gelenk.Pulling({ canvas, orbit, model, scene, computation, redraw });
    bar.update = () => playerBar.update();
    bar.showEvent = (event) => playerBar.showEvent(event);
    if (!picture.available) labels.setVisible(false);

    function draw(now) {
      request = 0;
      if (player.playing) player.advance(now);
      if (player.playing) {
        drawn.push(now);
        while (drawn[0] < now - 1000) drawn.shift();
        redraw();
      }
      model.setFrame(player.frame, player.fraction);
      if (second) second.setFrame(player.frame, player.fraction);
      arrows.update(player.frame, player.fraction);
      orbit.follow();
      if (pulling) pulling.update();
      bar.update();
      legend.update(orbit);
      panel.draw();
      if (picture.available) {
        picture.draw(scene, orbit.camera, player.playing);
        labels.update(orbit);
        triad.update(orbit.axes);
      }
      window.gelenk.ready = true;
    }

    // Drawing at once avoids the flash of an empty canvas that a new size would bring.
    function resize() {
      const stage = element("stage");
      const header = stage.querySelector("header");
      orbit.resize(stage.clientWidth, stage.clientHeight, header.offsetHeight);
      picture.resize(orbit.width, orbit.height);
      picture.draw(scene, orbit.camera, player.playing);
      redraw();
    }

    function setTheme(theme) {
      document.documentElement.dataset.theme = theme;
      const colors = readColors();
      const background = new THREE.Color(colors.back);
      model.setTheme(background);
      if (second) second.setTheme(background);
      if (grid) grid.material.color.set(colors.grid);
      picture.setBackground(background);
      panel.setColors(colors);
      redraw();
    }

    const preference = window.matchMedia("(prefers-color-scheme: dark)");
    let chosen = null;
    const isDark = () => (chosen === null ? preference.matches : chosen);
    const applyTheme = () => setTheme(isDark() ? "dark" : "light");
    preference.addEventListener("change", applyTheme);
    const toggleTheme = () => {
      chosen = !isDark();
      applyTheme();
    };
    element("theme").addEventListener("click", toggleTheme);

    const setCamera = (name) => {
      if (!orbit.setView(name)) throw new RangeError("no view named " + name);
      redraw();
    };
    for (const button of document.querySelectorAll("[data-view]")) {
      button.addEventListener("click", () => setCamera(button.dataset.view));
    }

    let trails = false;
    const toggleLabels = Gelenk.toggleButton("show-labels", () => labels.visible, (on) => {
      labels.setVisible(on && picture.available);
      redraw();
    });
    const toggleTrails = Gelenk.toggleButton("show-trails", () => trails, (on) => {
      trails = on;
      model.showTrails(on);
      redraw();
    });
    const toggleForces = Gelenk.toggleButton("show-forces", () => arrows.visible, (on) => {
      arrows.setVisible(on);
      redraw();
    });
    const toggleAxes = Gelenk.toggleButton("show-axes", () => Boolean(axes && axes[0] && axes[0].visible), (on) => {
      axes = axes || Gelenk.makeAxes(recording, model);
      for (const group of axes) group.visible = on;
      redraw();
    });
    const toggleFollowing = Gelenk.toggleButton("follow", () => orbit.following, (on) => {
      orbit.setFollowing(on);
      redraw();
    });
    const togglePanel = Gelenk.toggleButton("show-panel", () => panel.visible, (on) => panel.setVisible(on));
    element("show-panel").hidden = !panel.available;
    element("show-trails").hidden = recording.frames < 2;
    element("show-forces").hidden = !arrows.available;
    element("show-axes").hidden = !recording.frameAxes.length;
    const moves = recording.frames > 1 || recording.live;
    element("follow").hidden = !moves;
    element("show-labels").hidden = !labels.items.length;
    const toggleHelp = Gelenk.setUpHelp(recording.version);

    const step = (event, direction) => {
      if (player.playing) player.pause();
      player.show(player.frame + direction * (event.shiftKey ? 10 : 1));
    };
    const zoom = (factor) => {
      orbit.zoom(factor, 0, 0);
      redraw();
    };
    Gelenk.listenToKeys({
      " ": () => player.toggle(),
      ArrowLeft: (event) => step(event, -1),
      ArrowRight: (event) => step(event, 1),
      Home: () => player.show(0),
      End: () => player.show(recording.frames - 1),
      ".": () => computation && computation.singleStep(),
      r: () => computation && computation.reset(),
      m: () => computation && computation.mark(),
      b: () => computation && computation.returnToMark(),
      1: () => setCamera("front"),
      2: () => setCamera("side"),
      3: () => setCamera("top"),
      4: () => setCamera("start"),
      f: () => setCamera("fit"),
      "+": () => zoom(0.85),
      "=": () => zoom(0.85),
      "-": () => zoom(1 / 0.85),
      l: toggleLabels,
      t: () => recording.frames > 1 && toggleTrails(),
      v: () => arrows.available && toggleForces(),
      x: () => recording.frameAxes.length && toggleAxes(),
      c: () => moves && toggleFollowing(),
      p: () => panel.available && togglePanel(),
      d: toggleTheme,
      "?": toggleHelp
    });

    Gelenk.attachPointers(canvas, orbit, redraw);
    canvas.addEventListener("webglcontextrestored", redraw);
    window.gelenk = Gelenk.makeInterface({ recording, model, second, orbit, player, canvas, setCamera, drawn: () => drawn });
    window.gelenk.live = live;
    window.gelenk.computation = computation;
    window.gelenk.chooseMode = (number) => modeBar.choose(number);
    applyTheme();
    // A vehicle that travels far would be a dot.
    model.setFrame(0, 0);
    if (moves && model.radius > farAway * model.measureBodies().radius) toggleFollowing();
    new ResizeObserver(resize).observe(element("stage"));
    resize();
  }

  // What tests and scripts may use of a page.
  Gelenk.makeInterface = function ({ recording, model, second, orbit, player, canvas, setCamera, drawn }) {
    // Between a key press and the next draw the objects lag behind the player.
    const bodyNamed = (name, of = model) => {
      const body = of && of.body(name);
      if (!body) throw new RangeError("no body named " + name);
      of.setFrame(player.frame, player.fraction);
      return body;
    };
    return {
      ready: false,
      get frames() { return recording.frames; },
      get frame() { return player.frame; },
      get time() { return player.time; },
      get playing() { return player.playing; },
      play: () => player.play(),
      pause: () => player.pause(),
      show: (k) => player.show(k),
      // Of the first run, or of the second that is laid over it.
      pose(name, run = 1) {
        const body = bodyNamed(name, run === 2 ? second : model);
        body.updateWorldMatrix(true, false);
        const [p, q, scale] = [new THREE.Vector3(), new THREE.Quaternion(), new THREE.Vector3()];
        body.matrixWorld.decompose(p, q, scale);
        return { p: p.toArray(), q: q.toArray() };
      },
      // Pixel in the page, so that it can be found in a screenshot; null behind the camera.
      project(name) {
        const body = bodyNamed(name);
        body.updateWorldMatrix(true, false);
        const point = body.userData.center.clone().applyMatrix4(body.matrixWorld);
        const pixel = orbit.project(point, point);
        const box = canvas.getBoundingClientRect();
        return pixel && [pixel[0] + box.left, pixel[1] + box.top];
      },
      framesPerSecond() {
        const times = drawn();
        const span = times.length > 1 ? times[times.length - 1] - times[0] : 0;
        return span > 0 ? 1000 * (times.length - 1) / span : 0;
      },
      setCamera
    };
  };

  if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", start);
  else queueMicrotask(start);  // when all parts of this script are defined
})();
