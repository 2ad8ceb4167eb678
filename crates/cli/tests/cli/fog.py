"""Reads a fog volume by OpenVDB and prints what it finds as JSON; ends with 77 where OpenVDB is missing."""

import importlib.util
import json
import sys

NAME = next((name for name in ("openvdb", "pyopenvdb") if importlib.util.find_spec(name)), None)
if NAME is None:
    sys.exit(77)
grids, _ = importlib.import_module(NAME).readAll(sys.argv[1])
print(json.dumps({
    grid.name: {
        "type": grid.valueTypeName,
        "class": grid.gridClass,
        "half": grid.saveFloatAsHalf,
        "background": grid.background,
        "active": grid.activeVoxelCount(),
        "step": grid.transform.voxelSize(),
        "origin": grid.transform.indexToWorld((0, 0, 0)),
        "metadata": {key: value for key, value in grid.metadata.items()},
        "values": [[*item.min, item.value] for item in grid.citerOnValues()],
    }
    for grid in grids
}))
