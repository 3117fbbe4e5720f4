// Solves positions of a changed machine and sums maps, in a worker of its own or, where there are none, on the page.

function solvePositions(db, positions, factors, damping) {
  return positions.map((p) => changedSystem(db, p, factors, damping));
}

if (typeof document === "undefined") {
  let db = null;
  // The systems of the last settings that a map was asked for, by position.
  let kept = { key: null, systems: new Map() };
  const systemAt = ({ key, factors, damping }, p) => {
    if (kept.key !== key) kept = { key, systems: new Map() };
    if (!kept.systems.has(p)) {
      kept.systems.set(p, key === "" ? nominalSystem(db, p) : changedSystem(db, p, factors, damping));
    }
    return kept.systems.get(p);
  };
  const answer = ({ positions, factors, damping, sum }) => {
    if (!sum) return solvePositions(db, positions, factors, damping);
    const systems = positions.map((p) => systemAt(sum, p));
    return sumMap(systems, sum.o, sum.i, db.header.inputs.length, sum.frequencies, sum.power, responseAt);
  };
  self.onmessage = ({ data }) => {
    if (data.open) {
      db = openDatabase(data.open);
      // The first solution runs before the code is compiled for speed: not while someone waits.
      const some = Array.from(db.positions.keys()).slice(0, 40);
      solvePositions(db, some, new Float64Array(db.header.springs.length).fill(1.01), null);
      return;
    }
    try {
      self.postMessage({ job: data.job, result: answer(data) });
    } catch (error) {
      self.postMessage({ job: data.job, error: String(error.message || error) });
    }
  };
}
