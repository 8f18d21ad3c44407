// usage: node simplify.js METHOD GRID COLUMNS ROWS DX DY ERROR MESH
// delatin and martini over a window of 64-bit float heights, within ERROR metres as they understand it;
// writes a PLY mesh of doubles and prints the processor seconds of the simplification.
import fs from 'node:fs';

const makers = {
  async delatin(heights, columns, rows, error) {
    const { default: Delatin } = await import('delatin');
    return timed(() => {
      const tin = new Delatin(heights, columns, rows);
      tin.run(error);
      return { corners: tin.coords, triangles: tin.triangles };
    });
  },
  async martini(heights, columns, rows, error) {
    const { default: Martini } = await import('@mapbox/martini');
    // It takes squares of 2^k + 1 samples: the last column and row are repeated up to there.
    const side = 2 ** Math.ceil(Math.log2(Math.max(columns, rows) - 1)) + 1;
    const square = Float64Array.from({ length: side * side }, (_, i) =>
      heights[repeated(i % side, columns) + repeated(Math.floor(i / side), rows) * columns]);
    return timed(() => {
      const { vertices, triangles } = new Martini(side).createTile(square).getMesh(error);
      return { corners: vertices, triangles };
    });
  },
};

const repeated = (k, count) => Math.min(k, count - 1);

function timed(work) {
  const before = process.cpuUsage();
  const made = work();
  const { user, system } = process.cpuUsage(before);
  return { ...made, seconds: (user + system) / 1e6 };
}

function plyOf(heights, columns, rows, dx, dy, corners, triangles) {
  const vertices = corners.length / 2;
  const faces = triangles.length / 3;
  const header = Buffer.from(
    'ply\nformat binary_little_endian 1.0\n' +
      `element vertex ${vertices}\nproperty double x\nproperty double y\nproperty double z\n` +
      `element face ${faces}\nproperty list uchar int vertex_indices\nend_header\n`,
  );
  const body = Buffer.alloc(24 * vertices + 13 * faces);
  let at = 0;
  for (let i = 0; i < vertices; ++i) {
    const [column, row] = [corners[2 * i], corners[2 * i + 1]];
    const height = heights[repeated(row, rows) * columns + repeated(column, columns)];
    for (const value of [column * dx, -row * dy, height]) at = body.writeDoubleLE(value, at);
  }
  for (let i = 0; i < triangles.length; i += 3) {
    at = body.writeUInt8(3, at);
    for (const corner of counterClockwise(corners, triangles.slice(i, i + 3))) at = body.writeUInt32LE(corner, at);
  }
  return Buffer.concat([header, body]);
}

// Seen from above, with rows running southward.
function counterClockwise(corners, [a, b, c]) {
  const [ax, ay, bx, by, cx, cy] = [a, b, c].flatMap((i) => [corners[2 * i], corners[2 * i + 1]]);
  return (bx - ax) * (cy - ay) - (cx - ax) * (by - ay) < 0 ? [a, b, c] : [a, c, b];
}

const [method, grid, ...rest] = process.argv.slice(2);
const [columns, rows, dx, dy, error] = rest.slice(0, 5).map(Number);
const bytes = fs.readFileSync(grid);
// They know no holes.
const heights = new Float64Array(bytes.buffer, bytes.byteOffset, bytes.length / 8).map((h) => (Number.isNaN(h) ? 0 : h));
const { corners, triangles, seconds } = await makers[method](heights, columns, rows, error);
fs.writeFileSync(rest[5], plyOf(heights, columns, rows, dx, dy, corners, triangles));
console.log(JSON.stringify({ seconds }));
