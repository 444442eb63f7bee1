// Links of the arm fade while they are between the eye and what one looks at: the curve that the arm
// follows, both of its ends, and the obstacles where they are few. A pointer reaches what is behind
// any link, as viser lets it reach only what can be clicked or dragged.
window.abiSight = {
  FADED: 0.28,  // opacity of a link in the way
  CURVE: 24,  // points of the curve that are looked for
  MOST: 0.12,  // part of them that one link may hide
  FEW: 8,  // obstacles that are looked for, at most
  BEFORE: 0.08,  // of the way from start to goal: what is so near before a point belongs to it

  // Points in three's world: first those each of which is to be seen, then those of the curve.
  targets(nodes, state) {
    const vector = () => nodes[""].position.clone(), places = [];
    const obstacles = Object.keys(nodes).filter(name => /^\/obstacle_\d+$/.test(name) && nodes[name]);
    const few = obstacles.length <= this.FEW ? obstacles : [];
    for (const name of ["/start", "/goal", ...few]) {
      if (nodes[name]) places.push(vector().setFromMatrixPosition(nodes[name].matrixWorld));
    }
    const curve = ["/curve/quadratic", "/curve/bspline"].map(name => state[name])
      .filter(line => line?.effectiveVisibility && line.message.props.points.length > 6)
      .sort((a, b) => b.message.props.thickness - a.message.props.thickness)[0];
    const points = curve?.message.props.points ?? [], step = 6 * Math.ceil(points.length / 6 / this.CURVE);
    const along = [];
    for (let k = 0; k + 2 < points.length; k += step) {
      along.push(vector().set(points[k], points[k + 1], points[k + 2]).applyMatrix4(nodes[""].matrixWorld));
    }
    return [places, along];
  },

  // Meshes of the links that are drawn.
  links(nodes, state) {
    const found = [];
    for (const [name, node] of Object.entries(nodes)) {
      if (!node || !/^\/(arm|robot)\/.*\/(mesh|red)$/.test(name) || !state[name]?.effectiveVisibility) continue;
      node.traverse(part => part.isMesh && found.push(part));
    }
    return found;
  },

  // Whether the straight way from an eye to a point meets a mesh's box, but for its last part.
  hides(mesh, eye, point, near) {
    if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
    const {min, max} = mesh.geometry.boundingBox, inverse = mesh.matrixWorld.clone().invert();
    const from = eye.clone().applyMatrix4(inverse), to = point.clone().applyMatrix4(inverse);
    let first = 0, last = 1 - near / eye.distanceTo(point);
    for (const axis of ["x", "y", "z"]) {
      const way = to[axis] - from[axis];
      const [a, b] = [(min[axis] - from[axis]) / way, (max[axis] - from[axis]) / way];
      if (way === 0 && (from[axis] < min[axis] || from[axis] > max[axis])) return false;
      if (way === 0) continue;
      first = Math.max(first, Math.min(a, b));
      last = Math.min(last, Math.max(a, b));
    }
    return first < last;
  },

  update() {
    const viser = window.__viserMutable, state = window.__viserSceneTree?.getState();
    if (!viser?.camera || !state || !viser.nodeRefFromName[""]) return;
    const nodes = viser.nodeRefFromName, [places, along] = this.targets(nodes, state);
    if (places.length < 2) return;
    const eye = places[0].clone().setFromMatrixPosition(viser.camera.matrixWorld);
    const near = this.BEFORE * places[0].distanceTo(places[1]);
    let changed = false;
    for (const mesh of this.links(nodes, state)) {
      const hidden = points => points.filter(point => this.hides(mesh, eye, point, near)).length;
      const faded = hidden(places) > 0 || hidden(along) > this.MOST * along.length;
      if (mesh.material.transparent === faded) continue;
      Object.assign(mesh.material, {
        transparent: faded, opacity: faded ? this.FADED : 1, depthWrite: !faded, needsUpdate: true,
      });
      changed = true;
    }
    if (changed) viser.requestRender();
  },
};
clearInterval(window.abiSighting);
window.abiSighting = setInterval(() => document.hidden || window.abiSight.update(), 120);
