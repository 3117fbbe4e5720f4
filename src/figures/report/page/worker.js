// Solves positions of a changed machine, in a worker of its own or, where there are none, on the page.

function solvePositions(db, positions, factors, damping) {
  return positions.map((p) => changedSystem(db, p, factors, damping));
}

if (typeof document === "undefined") {
  let db = null;
  self.onmessage = (event) => {
    const { open, job, positions, factors, damping } = event.data;
    if (open) {
      db = openDatabase(open);
      // The first solution runs before the code is compiled for speed: not while someone waits.
      const some = Array.from(db.positions.keys()).slice(0, 40);
      solvePositions(db, some, new Float64Array(db.header.springs.length).fill(1.01), null);
      return;
    }
    try {
      const systems = solvePositions(db, positions, factors, damping);
      self.postMessage({ job, positions, systems });
    } catch (error) {
      self.postMessage({ job, error: String(error.message || error) });
    }
  };
}
