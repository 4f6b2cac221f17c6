// SPDX-License-Identifier: BSD-3-Clause
// The thread of a page that computes: it unpacks the core, and carries out the messages of the page.
(function () {
  "use strict";

  const period = 1000 / 60;

  async function unpacked(text) {
    const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
  }

  // receive(message) carries out a message of the page; post sends one to it.
  globalThis.makeGelenkWorker = function (post) {
    let session = null;
    let last = 0;

    async function guarded(act) {
      try {
        act();
      } catch (error) {
        await session.recover(error).catch((last) => post({ type: "unusable", text: last.message }));
      }
    }

    async function tick() {
      const now = performance.now();
      await guarded(() => session.tick(now - last));
      last = now;
      setTimeout(tick, Math.max(1, period - (performance.now() - now)));
    }

    async function start(message) {
      const begin = performance.now();
      try {
        const core = await globalThis.GelenkCore.load(await unpacked(message.core));
        session = new globalThis.GelenkSession(core, message, post);
        const warnings = session.begin();
        post({ type: "ready", variables: session.plant.variables, warnings, duration: performance.now() - begin });
        session.send([]);
      } catch (error) {
        post({ type: "unusable", text: error.message });
        return;
      }
      last = performance.now();
      tick();
    }

    return (message) => {
      if (message.type === "start") start(message);
      else if (session) guarded(() => session[message.type](message));
    };
  };

  if (typeof WorkerGlobalScope !== "undefined") {
    const receive = globalThis.makeGelenkWorker((message) => globalThis.postMessage(message));
    globalThis.addEventListener("message", (event) => receive(event.data));
  }
})();
