"""VTK's greedy terrain decimation over a window of 64-bit float heights, on its grid of unit spacing (in metres it
leaves triangles without area). It knows no holes and is given 0 there.

usage: vtk_greedy.py GRID COLUMNS ROWS DX DY ERROR MESH
Writes a PLY mesh of doubles and prints the processor seconds of the simplification.
"""
import json
import sys
import time

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersHybrid import vtkGreedyTerrainDecimation


def decimate(heights, error):
    rows, columns = heights.shape
    image = vtkImageData()
    image.SetDimensions(columns, rows, 1)
    northward = np.ascontiguousarray(heights[::-1])  # VTK's rows run northward
    image.GetPointData().SetScalars(numpy_to_vtk(northward.ravel(), deep=True))
    filter_ = vtkGreedyTerrainDecimation()
    filter_.SetInputData(image)
    filter_.SetErrorMeasureToAbsoluteError()
    filter_.SetAbsoluteError(error)
    filter_.BoundaryVertexDeletionOff()  # else the outline keeps its corners alone, whatever the error
    filter_.Update()
    return filter_.GetOutput()


def write_ply(path, vertices, triangles):
    records = np.zeros(len(triangles), dtype=[("n", "u1"), ("v", "<u4", 3)])
    records["n"], records["v"] = 3, triangles
    with open(path, "wb") as file:
        file.write(
            f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
            "property double x\nproperty double y\nproperty double z\n"
            f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n".encode()
        )
        file.write(vertices.astype("<f8").tobytes() + records.tobytes())


def main():
    grid, columns, rows = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    dx, dy, error = map(float, sys.argv[4:7])
    heights = np.nan_to_num(np.fromfile(grid).reshape(rows, columns))
    before = time.process_time()
    mesh = decimate(heights, error)
    seconds = time.process_time() - before

    points = vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)
    column, row = np.rint(points[:, 0]).astype(int), rows - 1 - np.rint(points[:, 1]).astype(int)
    vertices = np.column_stack([column * dx, -row * dy, heights[row, column]])
    triangles = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    write_ply(sys.argv[7], vertices, triangles)
    print(json.dumps({"seconds": seconds}))


main()
